#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_trust.sh - no result is silently wrong: errors and energies reported by runs, and their end
# with status 3. Each mechanism is a small one with a known answer.
set -u
. tests/claims.sh

# holds TEXT EXPRESSION: of v, the JSON object of the last claim
holds() {
    if python3 -c "import json, sys, math; v = json.load(open('$dir/out')); sys.exit(not ($2))"; then pass; else fail "$1"; fi
}

# ---- energies in closed form: m v' = -b v, m v' = F
cat >"$dir/sled.yaml" <<'END'
mechanism: sled
bodies:
  sled: {joint: T x, mass: 2.385 kg, initial: {speed: 1.7 m/s}, damping: 0.731 N s/m, points: {p: [0, 0, 0]}}
  post: {joint: R -y, mass: 0.2 kg, centre: [0, 0, -0.3 m], inertia: {yy: 1e-3 kg m^2}, initial: {position: 0.4 rad}, spring: {k: 0.83 N m/rad, theta0: 0.1 rad}}
inputs: {push: {force: sled.p, direction: [1, 0, 0]}}
outputs: {x: {joint: sled, read: position}}
simulation: {dt: 1 ms, until: 2 s}
END
claim 0 "a damped sled" "$stein" simulate "$dir/sled.yaml" --json
holds "loses what its damper takes" \
    "abs(v['energy']['work']['sled joint'] + 0.5 * 2.385 * 1.7**2 * (1 - math.exp(-2 * 0.731 * 2 / 2.385))) < 1e-10"
holds "and nothing else" "abs(v['energy']['unexplained']) < 1e-11 and abs(v['energy']['other']) < 1e-11"
holds "it is trusted" "v['trusted'] and v['errors']['deviation']['m'] < 1e-11 and v['errors']['lost'] is None"
printf 'time [s],push [N]\n0,3.1\n3,3.1\n' >"$dir/push.csv"
claim 0 "a sled that is pushed" "$stein" simulate "$dir/sled.yaml" --drive "$dir/push.csv" \
    --set sled.damping=0 --set sled.initial.speed=0.1 --json
holds "gets the work of the force" \
    "abs(v['energy']['work']['push input'] - 3.1 * (0.1 * 2 + 0.5 * 3.1 / 2.385 * 4)) < 1e-10"

# ---- an elastic ball keeps its energy, with any step, or the run is refused
cat >"$dir/ball.yaml" <<'END'
mechanism: ball
bodies:
  ball: {joint: T z, mass: 0.73 kg, initial: {position: 0.61 m}, points: {c: [0, 0, 0]}}
contacts:
  floor: {between: [{circle: {at: ball.c, radius: 20 mm}}, {line: {on: frame, at: [0, 0, -20 mm], facing: 90 deg}}], normal: {c: 6.1e6 N/m}}
outputs: {z: {joint: ball, read: position}}
simulation: {dt: 1 ms, until: 20 s}
END
claim 0 "an elastic ball, default settings" "$stein" simulate "$dir/ball.yaml" --json
holds "keeps its energy to 1e-6" "abs(v['energy']['end'] + v['energy']['stored'] - v['energy']['begin']) < 1e-6 * v['energy']['begin']"
cp "$dir/out" "$dir/first"
claim 0 "with another step" "$stein" simulate "$dir/ball.yaml" --dt 170us --json
holds "the motion is the same" "abs(v['final']['z'] - json.load(open('$dir/first'))['final']['z']) < 1e-4"
claim 3 "with steps as long as its contact" "$stein" simulate "$dir/ball.yaml" --integrator rk4 --dt 0.3ms
says "the energy is gone, and said so" '^stein: do not trust the result: .* of the energy is unexplained; use --integrator controlled, or --dt'
claim 0 "the same, allowed" "$stein" simulate "$dir/ball.yaml" --integrator rk4 --dt 0.3ms --allow-error --json
says "is told" '^stein: do not trust the result'
holds "in the object as well" "v['trusted'] is False and v['errors']['energy_share'] > 0.1"
claim 0 "a smaller tolerance" "$stein" simulate "$dir/ball.yaml" --until 5s --tolerance 1e-7 --json
holds "is used: it errs more" "v['errors']['deviation']['m'] > 1e-6"
claim 2 "a tolerance of 0" "$stein" simulate "$dir/ball.yaml" --tolerance 0
says "is none" 'tolerance 0: expected a positive number'

# ---- the same ball at rest, and so fast that a step is longer than its contact
claim 0 "a ball that lies on the floor" "$stein" simulate "$dir/ball.yaml" --set ball.initial.position=0 -o "$dir/rest.csv" --format csv-plain
claim 0 "does not begin to bounce" awk -F, 'NR > 1 && ($2 > 1e-9 || $2 < -2.001 * 0.73 * 9.81 / 6.1e6) { bad = 1 } END { exit bad }' "$dir/rest.csv"
claim 0 "a ball at 300 m/s" "$stein" simulate "$dir/ball.yaml" --set ball.initial.position=1 --set ball.initial.speed=-300 --until 50ms --json
holds "does not pass the floor" \
    "abs(v['final']['z'] - 300 * (0.05 - 1 / 300 - math.pi * math.sqrt(0.73 / 6.1e6))) < 0.02 and v['errors']['energy_share'] < 1e-9"

# ---- a body without mass between two slides along one axis: one vibrates against the other
cat >"$dir/xyx.yaml" <<'END'
mechanism: xyx
bodies:
  a: {joint: T x, mass: 0}
  b: {parent: a, joint: T y, mass: 1.3 kg}
  c: {parent: b, joint: T x, mass: 0.7 kg, spring: {k: 10 N/m}, initial: {position: 0.1 m}}
outputs: {a: {joint: a, read: position}, c: {joint: c, read: position}}
simulation: {dt: 1 ms, until: 1 s}
END
claim 0 "slides along x, y, x, the first without mass" "$stein" simulate "$dir/xyx.yaml" --json
holds "vibrate with the reduced mass" "abs(v['final']['c'] - 0.1 * math.cos(math.sqrt(10 * 2 / (1.3 * 0.7)))) < 1e-9"
holds "about their centre" "abs(2 * v['final']['a'] + 0.7 * (v['final']['c'] - 0.1)) < 1e-9"

# ---- a dead zone: free flights between two springs
cat >"$dir/dead.yaml" <<'END'
mechanism: dead
gravity: [0, 0, 0]
bodies:
  load: {joint: R y, inertia: {yy: 0.013 kg m^2}, backlash: {k: 1e4 N m/rad, gap: 0.04 rad}, initial: {speed: 0.31 rad/s}}
outputs: {q: {joint: load, read: position}, w: {joint: load, read: speed}}
simulation: {dt: 100 us, until: 1 s}
END
period=$(python3 -c 'import math; print(4 * 0.04 / 0.31 + 2 * math.pi * math.sqrt(0.013 / 1e4))')
claim 0 "a load with backlash" "$stein" simulate "$dir/dead.yaml" --until "$period" --json
holds "is back after two flights and one swing" "abs(v['final']['q']) < 1e-5 and abs(v['final']['w'] - 0.31) < 1e-5"

# ---- the same pendulums 10 000 times as small, of 1e-24 kg m^2, 100 times as fast
for size in 1 1e-4; do
    python3 - $size >"$dir/pendulums$size.yaml" <<'END'
import sys
s = float(sys.argv[1])
m = 1e-12 * (s / 1e-4) ** 3
print(f"""mechanism: pendulums
bodies:
  a: {{joint: R y, mass: {1e3 * m!r} kg, centre: [{s!r} m, 0, 0], inertia: {{yy: {100 * m * s * s!r} kg m^2}}}}
  b: {{parent: a, at: [{2 * s!r} m, 0, 0], joint: R y, mass: {m!r} kg, centre: [{0.1 * s!r} m, 0, 0], inertia: {{yy: {1e-4 * m * s * s!r} kg m^2}}}}
outputs: {{a: {{joint: a, read: position}}, b: {{joint: b, read: position}}}}
simulation: {{dt: {1e-3 * s ** 0.5!r} s, until: {3 * s ** 0.5!r} s}}""")
END
    claim 0 "pendulums of size $size" "$stein" simulate "$dir/pendulums$size.yaml" --json
    cp "$dir/out" "$dir/size$size"
done
holds "move alike" "all(abs(v['final'][k] - json.load(open('$dir/size1'))['final'][k]) < 1e-5 for k in 'ab') and v['trusted']"

# ---- a motion that is too stiff for explicit steps: how many were implicit, and why
claim 0 "a joint in thick oil" "$stein" simulate tests/validate/oil.yaml
shows "its steps become implicit, and why" \
    '^  [0-9]* of [0-9]* steps implicit: from [0-9.e-]* s on a motion that decays at 1[.]0e+07 1/s limited'
claim 0 "the same" "$stein" simulate tests/validate/oil.yaml --json
holds "in the object" "(lambda i: 0 < i['implicit'] < i['steps'] < 200 and i['stiff_from'] < 1e-4 and \
    abs(i['rate'] / 1e7 - 1) < 0.05 and i['refused'] is None)(v['integration'])"
claim 0 "implicit steps from the beginning" "$stein" simulate tests/validate/oil.yaml --integrator implicit
shows "all of them are" '^  \([0-9]*\) of \1 steps implicit$'
cat >"$dir/sticky.yaml" <<'END'
mechanism: sticky
bodies:
  block: {joint: T x, mass: 0.5 kg, friction: {A: 2 N, vt: 1e-9 m/s}, spring: {k: 100 N/m}, initial: {position: 15 mm}}
outputs: {x: {joint: block, read: position}}
simulation: {dt: 1 ms, until: 1 s}
END
claim 3 "friction that turns round at 1 nm/s" "$stein" simulate "$dir/sticky.yaml" --until 50ms
says "is chattered over, which is told with what helps" 'do not trust the result: .* or --integrator implicit$'
claim 0 "with that" "$stein" simulate "$dir/sticky.yaml" --integrator implicit --json
holds "it creeps as it should: 2 N tanh(v/vt) = 1.5 N" \
    "abs(v['final']['x'] - (0.015 - 1e-9 * math.atanh(0.75))) < 1e-12 and v['trusted']"
claim 0 "a loop" "$stein" simulate models/four_bar.yaml --until 10ms --integrator implicit
shows "has them as well" '^  \([0-9]*\) of \1 steps implicit$'
claim 0 "a sled that is pushed" "$stein" simulate "$dir/sled.yaml" --drive "$dir/push.csv" --integrator implicit
shows "has none, and why" '^  no step implicit: a signal has no derivative by time$'
claim 3 "a stiff one" "$stein" simulate "$dir/sled.yaml" --drive "$dir/push.csv" --set sled.damping=1e10
says "is told why nothing helps" 'the motion is too stiff: .* implicit ones cannot be taken: a signal has no derivative by time'
claim 0 "the sled" "$stein" simulate "$dir/sled.yaml" --json
holds "is not stiff" "v['integration'] == {'steps': 2000, 'implicit': 0, 'stiff_from': None, 'rate': None, 'refused': None, 'singular': 0}"
claim 0 "steps of fixed length" "$stein" simulate "$dir/sled.yaml" --integrator rk4 --json
holds "have none" "'integration' not in v"

# ---- reactions that the motion does not determine
cat >"$dir/door.yaml" <<'END'
mechanism: door
bodies:
  door: {joint: R z, mass: 2 kg, centre: [0.2 m, 0, 0.1 m], inertia: {xx: 0.02 kg m^2, yy: 0.02 kg m^2, zz: 0.02 kg m^2}, points: {top: [0, 0, 0.3 m]}, initial: {speed: 2 rad/s}}
points: {top: [0, 0, 0.3 m]}
loops: {upper: {between: [frame.top, door.top], hinge: z}}
outputs:
  upper: {loop: upper, read: reaction, component: fx}
  lower: {joint: door, read: reaction, component: fx}
  q: {joint: door, read: position}
simulation: {dt: 1 ms, until: 0.1 s}
END
claim 0 "a door on two hinges" "$stein" simulate "$dir/door.yaml" --json
says "is told that its forces are not determined" \
    '^stein: not determined by the motion: "upper", "lower"; more conditions, contacts or motions hold the same than are needed'
holds "in the object as well" "v['undetermined'] == ['upper', 'lower']"
claim 0 "the same, checked" "$stein" check "$dir/door.yaml" --json
says "is told it too" '^stein: not determined by the motion: "upper", "lower"'
holds "in the object" "v['undetermined'] == ['upper', 'lower']"

# ---- a ball comes to rest: its bounces pile up, the contact is kept
claim 0 "a ball that comes to rest" "$stein" simulate "$dir/ball.yaml" --set floor.normal.c=2e4 \
    --set floor.normal.D=0.9 --set ball.initial.position=5mm --until 60s --json
holds "lies where its weight presses it" "abs(v['final']['z'] + 0.73 * 9.81 / 2e4) < 1e-7"

# ---- a ball that hops by less than a step, for ever
claim 0 "a contact that chatters" "$stein" simulate "$dir/ball.yaml" --set ball.initial.position=20um --until 10s
says "is named, with how often" '^stein: contact "floor" chatters: it began [0-9]* times, every 0\.00[0-9]* s; give it damping'

# ---- a block that rocks on its edges: small differences grow
cat >"$dir/block.yaml" <<'END'
mechanism: block
bodies:
  x: {joint: T x}
  z: {parent: x, joint: T z}
  b: {parent: z, joint: R y, mass: 0.8 kg, inertia: {yy: 0.021 kg m^2}, points: {c: [0, 0, 0]}, initial: {position: 0.03 rad}}
contacts:
  f: {between: [{line: {on: b, at: [0, 0, -0.2 m], facing: -90 deg, extent: [-0.2 m, 0.2 m]}}, {line: {on: frame, at: [0, 0, -0.2 m], facing: 90 deg}}], normal: {c: 0.9e5 N/m, D: 0.2 s/m}, friction: {A: 0.45, vt: 1 mm/s}}
outputs: {x: {joint: x, read: position}, vx: {joint: x, read: speed}}
simulation: {dt: 500 us, until: 20 s}
END
claim 0 "a block that rocks and rests" "$stein" simulate "$dir/block.yaml" --json
holds "does not creep" "abs(v['final']['vx']) < 1e-5"
holds "its energy is right" "v['errors']['energy_share'] < 1e-4"
claim 3 "with fixed steps that its friction is too stiff for" "$stein" simulate "$dir/block.yaml" --integrator rk4
says "the contact is named" 'contact "f" needs .* s or less'

# ---- a block on a slope that dry friction would hold
cat >"$dir/slope.yaml" <<'END'
mechanism: slope
bodies:
  along: {joint: T x, mass: 0}
  box: {parent: along, joint: T z, mass: 52 g, points: {c: [0, 0, 0]}}
contacts:
  floor: {between: [{point: box.c}, {line: {on: frame, at: [0, 0, 0], facing: 84 deg}}], normal: {c: 1e4 N/m, D: 0.5 s/m}, friction: {A: 0.6, vt: 0.02 m/s}}
outputs: {x: {joint: along, read: position}, v: {joint: along, read: speed}}
simulation: {dt: 1 ms, until: 3 s}
END
claim 0 "a block on a slope, smooth friction" "$stein" simulate "$dir/slope.yaml"
says "creeps, which is told with what helps" '^stein: contact "floor" creeps at 0\.0035 m/s below its limit .*stick: yes'
sed 's/vt: 0.02 m.s/stick: yes/' "$dir/slope.yaml" >"$dir/stuck.yaml"
claim 0 "with that" "$stein" simulate "$dir/stuck.yaml" --json
holds "it stays where it stuck" "abs(v['final']['v']) < 1e-5 and abs(v['final']['x']) < 1e-4"
if [ -s "$dir/err" ]; then fail "says nothing"; else pass; fi
claim 0 "on a slope that is too steep" "$stein" simulate "$dir/slope.yaml" --set floor.line.facing=50deg
if grep -q creeps "$dir/err"; then fail "it slides, and does not creep"; else pass; fi
cat >"$dir/belt.yaml" <<'END'
mechanism: belt
bodies:
  belt: {joint: T x, mass: 5 kg, initial: {speed: 2 mm/s}}
  slide: {joint: T x, spring: {k: 1200 N/m}, damping: 60 N s/m}
  block: {parent: slide, joint: T z, mass: 0.8 kg, points: {sole: [0, 0, 0]}, initial: {position: -block.mass * 9.81 m/s^2 / top.normal.c}}
contacts:
  top: {between: [{point: block.sole}, {line: {on: belt, at: [0, 0, 0], facing: 90 deg}}], normal: {c: 20 kN/m, D: 5 s/m}, friction: {A: 0.14, stick: yes}}
inputs: {drive: {motion: belt}}
outputs: {x: {joint: slide, read: position}}
simulation: {dt: 1 ms, until: 4 s}
END
claim 0 "a belt that drags a block at its limit of dry friction" "$stein" simulate "$dir/belt.yaml"
if grep -q creeps "$dir/err"; then fail "friction that sticks does not creep"; else pass; fi

cat >"$dir/driven.yaml" <<'END'
mechanism: driven
bodies:
  belt: {joint: T x, mass: 5 kg, initial: {speed: 2 mm/s}, points: {end: [0, 0, 0.1]}}
  block: {joint: T z, mass: 0.8 kg, points: {sole: [0, 0, 0]}, initial: {position: -block.mass * 9.81 m/s^2 / top.normal.c}}
contacts:
  top: {between: [{point: block.sole}, {line: {on: belt, at: [0, 0, 0], facing: 90 deg}}], normal: {c: 20 kN/m, D: 5 s/m}, friction: {A: 0.14, vt: 0.02 m/s}}
inputs: {drive: {motion: belt}}
simulation: {dt: 1 ms, until: 4 s}
END
claim 0 "a belt that is driven below a block that cannot follow" "$stein" simulate "$dir/driven.yaml"
if grep -q creeps "$dir/err"; then fail "nothing could hold it: it does not creep"; else pass; fi
cat >"$dir/rows.py" <<'END'
for i in range(41): print("%g,%g" % (0.1 * i, 0.0002 * i))
END
{ echo "time,drive"; python3 "$dir/rows.py"; } >"$dir/drive.csv"
claim 0 "the same with a record" "$stein" simulate "$dir/driven.yaml" --drive "$dir/drive.csv"
if grep -q creeps "$dir/err"; then fail "nothing could hold it either"; else pass; fi

# ---- a pendulum that is chaotic
claim 0 "a motion that amplifies differences" "$stein" simulate models/double_pendulum.yaml --until 10s
says "says from when on its positions are not determined" '^stein: positions are not determined after [789]\.'

# ---- a motion that jumps
cat >"$dir/drive.yaml" <<'END'
mechanism: drive
bodies:
  sled: {joint: T x, mass: 1.3 kg}
inputs: {d: {motion: sled, idle: hold}}
outputs: {x: {joint: sled, read: position}, f: {input: d, read: force}}
simulation: {dt: 100 us, until: 1 s}
END
awk 'BEGIN { print "time [s],d [mm]"; for (i = 0; i <= 50; i++) printf "%g,%g\n", i / 50, i < 20 ? 0 : 37 }' >"$dir/jump.csv"
awk 'BEGIN { print "time [s],d [mm]"; for (i = 0; i <= 50; i++) printf "%g,%g\n", i / 50, 37 * (1 - cos(3.14159 * i / 50)) }' >"$dir/smooth.csv"
claim 3 "a prescribed position that jumps" "$stein" simulate "$dir/drive.yaml" --drive "$dir/jump.csv"
says "file, column, times and size" 'jump.csv: column "d" (line 1): the motion jumps by 0\.037 m between 0\.38 s and 0\.4 s; .* overshoots by 0\.0039'
claim 0 "one that does not" "$stein" simulate "$dir/drive.yaml" --drive "$dir/smooth.csv"
if [ -s "$dir/err" ]; then fail "says nothing"; else pass; fi

# ---- three hinges that carry one body, through gimbal lock
cat >"$dir/top.yaml" <<'END'
mechanism: top
gravity: [0, 0, 0]
bodies:
  a: {joint: R x, initial: {speed: 0.002 rad/s}}
  b: {parent: a, joint: R y, initial: {position: 1.1 rad, speed: 3 rad/s}}
  c: {parent: b, joint: R z, mass: 1 kg, inertia: {xx: 0.013 kg m^2, yy: 0.02 kg m^2, zz: 0.025 kg m^2}, initial: {speed: 0.002 rad/s}}
outputs: {b: {joint: b, read: position}}
simulation: {dt: 200 us, until: 1 s}
END
claim 0 "steps of controlled error pass it" "$stein" simulate "$dir/top.yaml" --json
holds "with the energy they had" "v['errors']['energy_share'] < 1e-8"
claim 3 "steps of fixed length do not" "$stein" simulate "$dir/top.yaml" --integrator rk4
says "it has a name" '^stein: gimbal lock: the axes of hinges "a" and "c" are nearly parallel at 0\.1'

# ---- units that were forgotten, inertias that no such body has: told, with line and column
cat >"$dir/arm.yaml" <<'END'
mechanism: arm
bodies:
  arm: {joint: R -y, mass: 82, centre: [0, 0, -60 mm], inertia: {yy: 3e-4}, points: {tip: [0, 0, -110 mm]}}
  hand: {parent: arm, at: arm.tip, joint: R -y, mass: 12 g, centre: [0, 0, -20], inertia: {yy: 2e-6 kg m^2}}
outputs: {q: {joint: arm, read: position}}
END
claim 0 "a mass without its unit" "$stein" check "$dir/arm.yaml"
says "has a place" 'arm.yaml:3:28: warning: arm.mass = "82" has no unit, so it is in kg: 6\.83e+03 times .*; is it in g?'
says "a length has one as well" 'arm.yaml:4:[0-9]*: warning: hand.centre.z = "-20" has no unit, so it is in m: .*; is it in mm?'
claim 0 "replaced from outside" "$stein" check "$dir/arm.yaml" --set arm.mass=82g --set hand.centre.z=-20mm
if [ -s "$dir/err" ]; then fail "nothing is said"; else pass; fi
sed 's/mass: 12 g/mass: 12/; s/-20\]/-20 mm]/' "$dir/arm.yaml" >"$dir/heavy.yaml"
claim 0 "no mass with a unit" "$stein" check "$dir/heavy.yaml"
says "what is denser than any metal" 'heavy.yaml:3:28: warning: arm.mass = "82" .* the largest length of the file is 0\.11 m; is it in g?'
sed 's/mass: 82/mass: 82 g/; s/-20\]/-20 mm]/; s/3e-4/300/' "$dir/arm.yaml" >"$dir/inert.yaml"
claim 0 "an inertia in other units" "$stein" check "$dir/inert.yaml"
says "is told with its mass and size" 'inert.yaml:3:[0-9]*: warning: the inertia of arm, 300 kg m^2, is .* times the largest of 0\.082 kg within 0\.11 m'
cat >"$dir/pin.yaml" <<'END'
mechanism: pin
bodies:
  rod:
    joint: R -y
    mass: 300 g
    centre: [0, 0, -400 mm]
    inertia: {yy: 0.052 kg m^2}
    points: {end: [0, 0, -600 mm]}
outputs: {q: {joint: rod, read: position}}
END
claim 0 "an inertia about the pin" "$stein" check "$dir/pin.yaml"
says "is told with that about the centre" 'pin.yaml:7:19: warning: `inertia:` of rod is about its centre of mass, .* write 0\.004 kg m^2, which is less by m c^2'
claim 0 "the one about the centre" "$stein" check "$dir/pin.yaml" --set rod.inertia.yy=0.004
if [ -s "$dir/err" ]; then fail "is right"; else pass; fi
sed '/inertia/d' "$dir/pin.yaml" >"$dir/point.yaml"
claim 0 "a rod without inertia" "$stein" check "$dir/point.yaml"
says "is told" 'point.yaml:4:5: warning: the body rod has no inertia about y'
sed 's/300 g/0/' "$dir/pin.yaml" >"$dir/light.yaml"
claim 0 "a rod without mass" "$stein" check "$dir/light.yaml"
says "is told" 'light.yaml:5:11: warning: the body rod has no mass'
for file in models/*.yaml models/robotran/*.yaml; do
    claim 0 "$file" "$stein" check "$file"
    if grep -q warning "$dir/err"; then fail "$file has no doubts"; else pass; fi
done

# ---- a fit with a weak prior finds what one with a strong prior does
cat >"$dir/axle.yaml" <<'END'
mechanism: axle
gravity: [0, 0, 0]
bodies:
  m: {joint: R y, inertia: {yy: 0.004 kg m^2}, damping: 0.03 N m s/rad, coulomb: {T: 0.04 N m, w: 0.01 rad/s}}
inputs: {tau: {torque: m}}
outputs: {q: {joint: m, read: position}}
simulation: {dt: 500 us, until: 2.4 s}
END
awk 'BEGIN { print "time [s],tau [N m]"; for (i = 0; i <= 480; i++) printf "%g,%.12g\n", i / 200, 0.9 * sin(6.1 * i / 200) + 0.6 * sin(20.3 * i / 200) }' >"$dir/tau.csv"
"$stein" simulate "$dir/axle.yaml" --drive "$dir/tau.csv" --every 5ms -o "$dir/truth.csv" --format csv-plain --set m.inertia.yy=0.0113 \
    --set m.damping=0.071 --set m.coulomb.T=0.13 >/dev/null 2>&1
# sums of 12 congruential numbers: normal to a few percent, sd 1 mrad
awk -F, 'NR == FNR { if (FNR > 1) u[FNR - 1] = $2; next }
    FNR == 1 { print "# noise q: 0.001 rad"; print "time [s],q [rad],tau [N m]"; next }
    { s = -6; for (k = 0; k < 12; k++) { x = (x * 16807 + 11) % 2147483647; s += x / 2147483647 }
      printf "%s,%.12g,%s\n", $1, $2 + 0.001 * s, u[FNR - 1] }' "$dir/tau.csv" "$dir/truth.csv" >"$dir/axle.csv"
for prior in 0.2 2 5; do
    claim 0 "prior $prior" "$stein" fit "$dir/axle.yaml" "$dir/axle.csv" --free m.damping,m.coulomb.T,m.inertia.yy \
        --prior $prior --json
    holds "converged, and the numbers are right" \
        "v['status'] == 'converged' and all(abs(p['value'] / t - 1) < 0.01 for p, t in zip(v['parameters'], (0.071, 0.13, 0.0113)))"
done

finish
