/* SPDX-License-Identifier: MIT
 * words.js - what the page says, in four languages. Words of the mechanism's file are in one; those
 * of the action of 1788 are known here by their English text. */
"use strict";

const Words = (() => {
  const languages = ["en", "de", "fr", "nl"];
  const names = ["English", "Deutsch", "Français", "Nederlands"];
  const all = {
    pressKey: ["Press the key", "Taste drücken", "Enfoncer la touche", "Toets indrukken"],
    push: ["Hold to push: {0}", "Halten und drücken: {0}", "Maintenir pour pousser : {0}", "Vasthouden en duwen: {0}"],
    space: ["space", "Leertaste", "espace", "spatie"],
    letGo: ["Let {0} go", "{0} loslassen", "Lâcher {0}", "{0} loslaten"],
    letGoKey: ["Let {0} go on the key", "{0} auf die Taste loslassen", "Lâcher {0} sur la touche", "{0} op de toets loslaten"],
    takeLoad: ["Take the load away", "Gewicht wegnehmen", "Retirer le poids", "Gewicht wegnemen"],
    again: ["Start again", "Von vorn", "Recommencer", "Opnieuw"],
    pause: ["Pause", "Pause", "Pause", "Pauze"],
    goOn: ["Go on", "Weiter", "Continuer", "Verder"],
    step: ["Step {0}", "Schritt {0}", "Pas de {0}", "Stap {0}"],
    lastStroke: ["Last stroke", "Letzter Schlag", "Dernière frappe", "Laatste aanslag"],
    lastMotion: ["Last motion", "Letzte Bewegung", "Dernier mouvement", "Laatste beweging"],
    freeze: ["Freeze to compare", "Zum Vergleich festhalten", "Figer pour comparer", "Vasthouden om te vergelijken"],
    thaw: ["Clear frozen ({0})", "Festgehaltene löschen ({0})", "Effacer les figées ({0})", "Vastgehouden wissen ({0})"],
    frozen: ["Frozen: the next stroke is drawn over it.", "Festgehalten: der nächste Schlag wird darüber gezeichnet.", "Figée : la prochaine frappe sera dessinée par-dessus.", "Vastgehouden: de volgende aanslag wordt eroverheen getekend."],
    open: ["Measured stroke …", "Gemessener Schlag …", "Frappe mesurée …", "Gemeten aanslag …"],
    openMotion: ["Measured record …", "Messung …", "Mesure …", "Meting …"],
    opened: ["{0} is drawn over the traces as dots.", "{0} ist als Punkte in den Verläufen.", "{0} est tracé en points sur les courbes.", "{0} staat als punten in het verloop."],
    notOpened: ["{0} is no record of this mechanism: a line with time and names of the outputs is expected, then numbers ({1}).", "{0} ist keine Messung dieses Mechanismus: erwartet ist eine Zeile mit der Zeit und Namen der Größen, dann Zahlen ({1}).", "{0} n’est pas une mesure de ce mécanisme : il faut une ligne avec le temps et les noms des grandeurs, puis des nombres ({1}).", "{0} is geen meting van dit mechaniek: verwacht is een regel met tijd en namen van de grootheden, dan getallen ({1})."],
    tour: ["Out of regulation: find it", "Verstellt: finde den Fehler", "Déréglé : trouvez pourquoi", "Ontregeld: zoek de oorzaak"],
    tourStop: ["Stop the tour", "Rundgang beenden", "Arrêter la visite", "Rondleiding stoppen"],
    tourEnd: ["Done", "Fertig", "Terminé", "Klaar"],
    tour1: ["1 of 4. Press the key and watch the notch under the lens: the beak slips out just before the hammer strikes.", "1 von 4. Drücken Sie die Taste und beobachten Sie die Kerbe unter der Lupe: der Schnabel gleitet heraus, kurz bevor der Hammer schlägt.", "1 sur 4. Enfoncez la touche et regardez le cran sous la loupe : le bec en glisse juste avant que le marteau frappe.", "1 van 4. Druk de toets in en kijk naar de keep onder de loep: de snavel glijdt eruit vlak voordat de hamer slaat."],
    tour2: ["2 of 4. Now somebody has moved the stop by a quarter of a millimetre. Press again and look at the notch and at the outcome.", "2 von 4. Jetzt hat jemand den Anschlag um einen Viertelmillimeter verstellt. Drücken Sie noch einmal und achten Sie auf Kerbe und Ausgang.", "2 sur 4. Quelqu’un a déplacé la butée d’un quart de millimètre. Enfoncez encore la touche, regardez le cran et le résultat.", "2 van 4. Nu heeft iemand de stop een kwart millimeter verzet. Druk opnieuw en let op de keep en de uitkomst."],
    tour3: ["3 of 4. The hammer gets out too late or not at all: it would damp the string that it strikes. Turn the stop (dx) to the left, a little each time, and press, until it escapes 1 to 4 mm below the string. The last stroke: {0} mm at dx = {1} mm.", "3 von 4. Der Hammer kommt zu spät oder gar nicht heraus: er würde die Saite dämpfen, die er anschlägt. Drehen Sie den Anschlag (dx) nach links, jedes Mal ein wenig, und drücken Sie, bis er 1 bis 4 mm unter der Saite auslöst. Zuletzt: {0} mm bei dx = {1} mm.", "3 sur 4. Le marteau sort trop tard ou pas du tout : il étoufferait la corde qu’il frappe. Tournez la butée (dx) vers la gauche, un peu à la fois, et enfoncez, jusqu’à ce qu’il échappe de 1 à 4 mm sous la corde. Dernière frappe : {0} mm à dx = {1} mm.", "3 van 4. De hamer komt te laat of helemaal niet los: hij zou de snaar dempen die hij aanslaat. Draai de stop (dx) naar links, telkens een beetje, en druk, tot hij 1 tot 4 mm onder de snaar ontsnapt. Laatste aanslag: {0} mm bij dx = {1} mm."],
    tour4: ["4 of 4. Found: the hammer escapes {0} mm below the string at dx = {1} mm. A tenth of a millimetre at the stop moves that by 2 mm; the chart has your strokes beside the paper’s line.", "4 von 4. Gefunden: der Hammer löst {0} mm unter der Saite aus, bei dx = {1} mm. Ein Zehntelmillimeter am Anschlag ändert das um 2 mm; das Bild zeigt Ihre Schläge neben der Linie der Veröffentlichung.", "4 sur 4. Trouvé : le marteau échappe {0} mm sous la corde à dx = {1} mm. Un dixième de millimètre à la butée change cela de 2 mm ; le graphique montre vos frappes près de la droite de l’article.", "4 van 4. Gevonden: de hamer ontsnapt {0} mm onder de snaar bij dx = {1} mm. Een tiende millimeter aan de stop verandert dat 2 mm; de grafiek toont uw aanslagen naast de lijn van het artikel."],
    restarts: ["{0} (starts again)", "{0} (beginnt von vorn)", "{0} (recommence)", "{0} (begint opnieuw)"],
    speed: ["Speed", "Tempo", "Vitesse", "Snelheid"],
    realTime: ["real time", "Echtzeit", "temps réel", "echte tijd"],
    slower: ["1/{0} of real time", "1/{0} der Echtzeit", "1/{0} du temps réel", "1/{0} van de echte tijd"],
    soundOn: ["Sound on", "Ton an", "Son activé", "Geluid aan"],
    soundOff: ["Sound off", "Ton aus", "Son coupé", "Geluid uit"],
    language: ["Language", "Sprache", "Langue", "Taal"],
    helpOpen: ["What is this? Explains the parts", "Was ist das? Erklärt die Teile", "Qu’est-ce que c’est ? Explique les pièces", "Wat is dit? Legt de onderdelen uit"],
    help: ["What is this?", "Was ist das?", "Qu’est-ce que c’est ?", "Wat is dit?"],
    close: ["Close", "Schließen", "Fermer", "Sluiten"],
    mechanism: ["The mechanism", "Der Mechanismus", "Le mécanisme", "Het mechaniek"],
    toScale: ["The mechanism, drawn to scale", "Der Mechanismus, maßstäblich", "Le mécanisme, à l’échelle", "Het mechaniek, op schaal"],
    play: ["Play", "Spielen", "Jouer", "Spelen"],
    regulation: ["Regulation", "Regulierung", "Réglage", "Regulering"],
    dialsNote: ["Turn them while it runs: they move slowly, as a hand would.", "Auch im Lauf verstellbar: sie bewegen sich langsam, wie von Hand.", "À régler pendant la marche : tout bouge lentement, comme à la main.", "Ook tijdens het lopen te verstellen: ze bewegen langzaam, als met de hand."],
    escapement: ["Escapement", "Auslösung", "Échappement", "Echappement"],
    chart: ["Escapement height of each stroke against the stop's place, with the paper's line of minus 20 millimetres a millimetre; the numbers are in the table", "Höhe der Auslösung jedes Schlags über der Stellung des Anschlags, mit der Linie der Veröffentlichung: minus 20 Millimeter je Millimeter; die Zahlen stehen in der Tabelle", "Hauteur d’échappement de chaque frappe selon la position de la butée, avec la droite de l’article : moins 20 millimètres par millimètre ; les nombres sont dans le tableau", "Hoogte van het echappement van elke aanslag tegen de stand van de stop, met de lijn van het artikel: min 20 millimeter per millimeter; de getallen staan in de tabel"],
    hollow: ["Hollow: a forced escapement, after the blow.", "Hohl: erzwungene Auslösung, nach dem Schlag.", "Creux : échappement forcé, après le coup.", "Hol: gedwongen echappement, na de slag."],
    traces: ["Traces", "Verläufe", "Courbes", "Verloop"],
    tracesLabel: ["Output channels over time; their values are listed below", "Größen über der Zeit; ihre Werte stehen darunter", "Grandeurs au cours du temps ; leurs valeurs sont dessous", "Grootheden over de tijd; hun waarden staan eronder"],
    strokes: ["Strokes", "Schläge", "Frappes", "Aanslagen"],
    escapesAt: ["escapes at", "löst aus bei", "échappe à", "ontsnapt op"],
    strikesWith: ["strikes with", "schlägt mit", "frappe à", "slaat met"],
    peak: ["peak", "Spitze", "pic", "piek"],
    outcome: ["outcome", "Ausgang", "résultat", "uitkomst"],
    tableEmpty: ["Each stroke leaves a row here.", "Jeder Schlag hinterlässt hier eine Zeile.", "Chaque frappe laisse une ligne ici.", "Elke aanslag laat hier een regel achter."],
    failed: ["It came apart: {0}. Start again, or turn the last dial back.", "Das ging nicht gut: {0}. Von vorn beginnen oder den letzten Regler zurückdrehen.", "Cela n’a pas tenu : {0}. Recommencez, ou ramenez le dernier réglage.", "Dat ging mis: {0}. Begin opnieuw of draai de laatste regelaar terug."],
    reset: ["reset", "zurück", "rétablir", "terug"],
    resetOf: ["Reset {0}", "{0} zurücksetzen", "Rétablir {0}", "{0} terugzetten"],
    finger: ["finger", "Finger", "doigt", "vinger"],
    pushing: ["push", "Schub", "poussée", "duw"],
    atRest: ["at rest", "in Ruhe", "au repos", "in rust"],
    paused: ["paused at {0}", "angehalten bei {0}", "arrêté à {0}", "gepauzeerd op {0}"],
    into: ["{0} into the stroke", "{0} nach Beginn des Schlags", "{0} après le début de la frappe", "{0} na het begin van de aanslag"],
    costs: ["a frame takes {0} to compute", "ein Bild braucht {0} Rechenzeit", "une image demande {0} de calcul", "een beeld kost {0} rekentijd"],
    costsShort: ["{0} a frame", "{0} je Bild", "{0} par image", "{0} per beeld"],
    hintLoad: ["Let the load go.", "Das Gewicht loslassen.", "Lâchez le poids.", "Laat het gewicht los."],
    hintKey: ["Hold the space bar, or press the key with finger or mouse.", "Leertaste halten oder die Taste mit Finger oder Maus drücken.", "Maintenez la barre d’espace, ou enfoncez la touche au doigt ou à la souris.", "Houd de spatiebalk in, of druk de toets in met vinger of muis."],
    hintPush: ["Hold the space bar, or press on the drawing.", "Leertaste halten oder auf die Zeichnung drücken.", "Maintenez la barre d’espace, ou appuyez sur le dessin.", "Houd de spatiebalk in, of druk op de tekening."],
    phase1: ["phase i, the beak’s tip on the roof", "Phase i, Schnabelspitze am Dach", "phase i, la pointe du bec sur le toit", "fase i, snavelpunt tegen het dak"],
    phase2: ["phase ii, the beak’s face on the roof", "Phase ii, Schnabelfläche am Dach", "phase ii, la face du bec sur le toit", "fase ii, snavelvlak tegen het dak"],
    phase3: ["phase iii, the beak’s face on the corner", "Phase iii, Schnabelfläche an der Ecke", "phase iii, la face du bec sur l’arête", "fase iii, snavelvlak tegen de hoek"],
    phase4: ["phase iv, the beak’s tip on the pawl", "Phase iv, Schnabelspitze an der Prellzunge", "phase iv, la pointe du bec sur le cliquet", "fase iv, snavelpunt tegen de pal"],
    struck: ["struck", "angeschlagen", "frappé", "geslagen"],
    "no blow": ["no blow", "kein Schlag", "pas de coup", "geen slag"],
    "missed the notch": ["missed the notch", "Kerbe verfehlt", "cran manqué", "keep gemist"],
    "struck, not escaped": ["struck, not escaped", "angeschlagen, nicht ausgelöst", "frappé, sans échapper", "geslagen, niet ontsnapt"],
    "no escapement": ["no escapement", "keine Auslösung", "pas d’échappement", "geen echappement"],
    "escaped, no blow": ["escaped, no blow", "ausgelöst, kein Schlag", "échappé, sans coup", "ontsnapt, geen slag"],
    forced: ["forced", "erzwungen", "forcé", "gedwongen"],
    sayStroke: ["Stroke {0}: {1}", "Schlag {0}: {1}", "Frappe {0} : {1}", "Aanslag {0}: {1}"],
    sayHeight: [", escapement {0} millimetres", ", Auslösung bei {0} Millimetern", ", échappement à {0} millimètres", ", echappement op {0} millimeter"],
    sayPeak: [", {0} newtons", ", {0} Newton", ", {0} newtons", ", {0} newton"],
    now: ["now", "jetzt", "maintenant", "nu"],
    headToString: ["head to string", "Kopf bis Saite", "tête à la corde", "kop tot snaar"],
    notchPhase: ["notch phase", "Phase der Kerbe", "phase du cran", "fase van de keep"],
    forces: ["forces", "Kräfte", "forces", "krachten"],
    stopAxis: ["stop, dx [mm]", "Anschlag, dx [mm]", "butée, dx [mm]", "stop, dx [mm]"],
    heightAxis: ["escapement below the string [mm]", "Auslösung unter der Saite [mm]", "échappement sous la corde [mm]", "echappement onder de snaar [mm]"],
    paperLine: ["the paper’s line", "Linie der Veröffentlichung", "droite de l’article", "lijn van het artikel"],
    pawl: ["pawl", "Prellzunge", "cliquet", "pal"], stop: ["stop", "Anschlag", "butée", "stop"],
    notch: ["notch", "Kerbe", "cran", "keep"], hammer: ["hammer", "Hammer", "marteau", "hamer"],
    string: ["string", "Saite", "corde", "snaar"], key: ["key", "Taste", "touche", "toets"],
    balancePin: ["balance pin", "Waagestift", "pointe de balancier", "balansstift"],
    fingerPlace: ["the finger’s place", "hier drückt der Finger", "place du doigt", "plaats van de vinger"],
    lens: ["notch, {0} times as large", "Kerbe, {0}-fach", "cran, agrandi {0} fois", "keep, {0} maal vergroot"],
    keys: ["Keys: ", "Tasten: ", "Touches : ", "Toetsen: "],
    keySpace: ["hold space to press", "Leertaste drückt", "espace pour appuyer", "spatie drukt"],
    keyLoad: ["L puts the load on and takes it away", "L setzt das Gewicht auf und nimmt es weg", "L pose et retire le poids", "L zet het gewicht erop en neemt het weg"],
    keyAgain: ["R starts again", "R beginnt von vorn", "R recommence", "R begint opnieuw"],
    keyPause: ["P pauses, a full stop makes one step", "P hält an, ein Punkt geht einen Schritt", "P met en pause, un point fait un pas", "P pauzeert, een punt doet één stap"],
    keyTab: ["Tab goes from slider to slider, arrows turn them", "Tab geht von Regler zu Regler, Pfeile drehen sie", "Tab passe d’un curseur à l’autre, les flèches les tournent", "Tab gaat van schuif naar schuif, pijlen verstellen ze"],
    same: ["The same numbers to the last bit: {0} of this mechanism end in state {1} here and in the library on the machine that wrote this page.", "Dieselben Zahlen bis aufs letzte Bit: {0} dieses Mechanismus enden hier und in der Bibliothek im Zustand {1}.", "Les mêmes nombres au dernier bit près : {0} de ce mécanisme finissent ici et dans la bibliothèque dans l’état {1}.", "Dezelfde getallen tot op de laatste bit: {0} van dit mechaniek eindigen hier en in de bibliotheek in toestand {1}."],
    other: ["State after {0} of this mechanism: {1} here, {2} in the library.", "Zustand nach {0} dieses Mechanismus: hier {1}, in der Bibliothek {2}.", "État après {0} de ce mécanisme : {1} ici, {2} dans la bibliothèque.", "Toestand na {0} van dit mechaniek: hier {1}, in de bibliotheek {2}."],
    foot: ["libstein {0} · mechanism {1}, equations {2} · step {3} · all that you see is computed in this page.", "libstein {0} · Mechanismus {1}, Gleichungen {2} · Schritt {3} · alles wird auf dieser Seite berechnet.", "libstein {0} · mécanisme {1}, équations {2} · pas {3} · tout est calculé dans cette page.", "libstein {0} · mechaniek {1}, vergelijkingen {2} · stap {3} · alles wordt op deze pagina berekend."],
    helpAction: [
      "<p>The mechanism of one note in a Viennese piano of 1788. A finger presses the <b>key</b>; a small hammer is thrown at the <b>string</b>, lets go of the key just before it strikes, and falls back, ready again. All of it is computed here, a hundred thousand times a second.</p><dl><dt>Key</dt><dd>The lever under the finger. It turns on the balance pin; felt stops its two ends.</dd><dt>Hammer</dt><dd>Hinged in a brass fork on the key, the <i>Kapsel</i>. Its head points to the player, its short end, the <b>beak</b>, away. It lies on soft loops.</dd><dt>Pawl</dt><dd>An upright lever on the frame, which a spring holds against its stop. As the key lifts the hammer, the beak hooks under the pawl’s <b>notch</b> and the head flies up: a lever on a lever.</dd><dt>Escapement</dt><dd>Near the string the beak slips out of the notch, and the hammer flies its last way free. Without that it would block the string it has just struck. If it gets out only after the blow, the escapement is <b>forced</b>.</dd><dt>The stop</dt><dd>The technician’s place of work. A tenth of a millimetre to the right (<i>dx</i>), and the hammer escapes 2 mm nearer to the string. Slips of paper do it. Too far, and it jams; too far left, and the beak misses the notch.</dd><dt>Phases</dt><dd>i the beak’s tip on the roof of the notch, ii its face on the roof, iii its face on the corner, iv after escapement its tip on the pawl’s face.</dd></dl>",
      "<p>Die Mechanik eines Tons in einem Wiener Klavier von 1788. Ein Finger drückt die <b>Taste</b>; ein kleiner Hammer wird gegen die <b>Saite</b> geworfen, löst sich kurz vor dem Schlag von der Taste und fällt zurück, wieder bereit. Alles wird hier berechnet, hunderttausendmal in der Sekunde.</p><dl><dt>Taste</dt><dd>Der Hebel unter dem Finger. Er dreht sich auf dem Waagestift; Filz hält seine beiden Enden auf.</dd><dt>Hammer</dt><dd>In einer Messinggabel auf der Taste gelagert, der <i>Kapsel</i>. Sein Kopf zeigt zum Spieler, sein kurzes Ende, der <b>Schnabel</b>, von ihm weg. Er ruht auf weichen Schlaufen.</dd><dt>Prellzunge</dt><dd>Ein stehender Hebel am Rahmen, den eine Feder an seinen Anschlag drückt. Hebt die Taste den Hammer, hakt der Schnabel unter die <b>Kerbe</b> der Prellzunge, und der Kopf fliegt hoch: ein Hebel auf einem Hebel.</dd><dt>Auslösung</dt><dd>Nahe der Saite gleitet der Schnabel aus der Kerbe, und der Hammer fliegt das letzte Stück frei. Sonst würde er die Saite dämpfen, die er gerade angeschlagen hat. Kommt er erst nach dem Schlag heraus, ist die Auslösung <b>erzwungen</b>.</dd><dt>Der Anschlag</dt><dd>Hier arbeitet der Klavierbauer. Ein Zehntelmillimeter nach rechts (<i>dx</i>), und der Hammer löst 2 mm näher an der Saite aus. Papierstreifen genügen. Zu weit, und er klemmt; zu weit links, und der Schnabel verfehlt die Kerbe.</dd><dt>Phasen</dt><dd>i Schnabelspitze am Dach der Kerbe, ii Schnabelfläche am Dach, iii Schnabelfläche an der Ecke, iv nach der Auslösung Schnabelspitze an der Fläche der Prellzunge.</dd></dl>",
      "<p>La mécanique d’une note dans un piano viennois de 1788. Un doigt enfonce la <b>touche</b> ; un petit marteau est lancé vers la <b>corde</b>, se libère de la touche juste avant de frapper et retombe, prêt de nouveau. Tout est calculé ici, cent mille fois par seconde.</p><dl><dt>Touche</dt><dd>Le levier sous le doigt. Il pivote sur la pointe de balancier ; du feutre arrête ses deux bouts.</dd><dt>Marteau</dt><dd>Articulé dans une fourche de laiton sur la touche, la <i>Kapsel</i>. Sa tête regarde le joueur, son bout court, le <b>bec</b>, l’opposé. Il repose sur des boucles souples.</dd><dt>Cliquet</dt><dd>Un levier dressé sur le bâti, qu’un ressort tient contre sa butée. Quand la touche lève le marteau, le bec s’accroche sous le <b>cran</b> du cliquet et la tête s’envole : un levier sur un levier.</dd><dt>Échappement</dt><dd>Près de la corde le bec glisse hors du cran, et le marteau vole librement jusqu’à elle. Sinon il étoufferait la corde qu’il vient de frapper. S’il ne sort qu’après le coup, l’échappement est <b>forcé</b>.</dd><dt>La butée</dt><dd>Là où travaille le technicien. Un dixième de millimètre à droite (<i>dx</i>), et le marteau échappe 2 mm plus près de la corde. Des bandes de papier y suffisent. Trop loin, il se bloque ; trop à gauche, le bec manque le cran.</dd><dt>Phases</dt><dd>i pointe du bec sur le toit du cran, ii face du bec sur le toit, iii face du bec sur l’arête, iv après l’échappement, pointe du bec sur la face du cliquet.</dd></dl>",
      "<p>Het mechaniek van één toon in een Weense piano uit 1788. Een vinger drukt de <b>toets</b> in; een kleine hamer wordt naar de <b>snaar</b> geworpen, komt vlak voor de slag los van de toets en valt terug, weer gereed. Alles wordt hier berekend, honderdduizend keer per seconde.</p><dl><dt>Toets</dt><dd>De hefboom onder de vinger. Hij draait op de balansstift; vilt stopt beide uiteinden.</dd><dt>Hamer</dt><dd>Scharniert in een messing vork op de toets, de <i>Kapsel</i>. Zijn kop wijst naar de speler, zijn korte eind, de <b>snavel</b>, van hem af. Hij rust op zachte lussen.</dd><dt>Pal</dt><dd>Een staande hefboom op het frame, die een veer tegen zijn stop houdt. Als de toets de hamer optilt, haakt de snavel onder de <b>keep</b> van de pal en vliegt de kop omhoog: een hefboom op een hefboom.</dd><dt>Echappement</dt><dd>Dicht bij de snaar glijdt de snavel uit de keep en vliegt de hamer het laatste stuk vrij. Anders zou hij de snaar dempen die hij net heeft aangeslagen. Komt hij pas na de slag los, dan is het echappement <b>gedwongen</b>.</dd><dt>De stop</dt><dd>Hier werkt de technicus. Een tiende millimeter naar rechts (<i>dx</i>), en de hamer ontsnapt 2 mm dichter bij de snaar. Strookjes papier volstaan. Te ver, en hij klemt; te ver naar links, en de snavel mist de keep.</dd><dt>Fasen</dt><dd>i snavelpunt tegen het dak van de keep, ii snavelvlak tegen het dak, iii snavelvlak tegen de hoek, iv na het echappement snavelpunt tegen het vlak van de pal.</dd></dl>"],
  };
  const file = { // words of models/stein1788.yaml
    "Viennese action of J. A. Stein, 1788, note F6": ["Wiener Mechanik von J. A. Stein, 1788, Ton f³", "Mécanique viennoise de J. A. Stein, 1788, note fa⁵", "Weens mechaniek van J. A. Stein, 1788, toon f³"],
    "key, hammer, pawl": ["Taste, Hammer, Prellzunge", "touche, marteau, cliquet", "toets, hamer, pal"],
    "stop (dx)": ["Anschlag (dx)", "butée (dx)", "stop (dx)"],
    "pawl spring": ["Feder der Prellzunge", "ressort du cliquet", "veer van de pal"],
    "notch angle": ["Winkel der Kerbe", "angle du cran", "hoek van de keep"],
    "leather friction": ["Reibung des Leders", "frottement du cuir", "wrijving van het leer"],
    "string height": ["Höhe der Saite", "hauteur de la corde", "hoogte van de snaar"],
    "felt of the loops": ["Filz der Schlaufen", "feutre des boucles", "vilt van de lussen"],
    "felt under the key": ["Filz unter der Taste", "feutre sous la touche", "vilt onder de toets"],
    "head leather": ["Leder des Kopfes", "cuir de la tête", "leer van de kop"],
    "load": ["Gewicht", "poids", "gewicht"],
    "string distance": ["Abstand zur Saite", "distance à la corde", "afstand tot de snaar"],
    "string force": ["Kraft an der Saite", "force sur la corde", "kracht op de snaar"],
    "notch force": ["Kraft in der Kerbe", "force dans le cran", "kracht in de keep"],
    "notch phase": ["Phase der Kerbe", "phase du cran", "fase van de keep"],
  };
  let now = 0;

  const fill = (text, args) => text.replace(/\{(\d)\}/g, (_, i) => args[+i]);
  const t = (key, ...args) => fill(all[key][now], args);

  return {
    languages, names, all, file, t,
    /* a language by its code, "de-AT" too; the first is English, which is for all others */
    choose(code) {
      now = Math.max(0, languages.indexOf(String(code).slice(0, 2).toLowerCase()));
      return languages[now];
    },
    /* a text of the mechanism's file */
    of: (text) => (now > 0 && file[text] ? file[text][now - 1] : text),
    /* all that stands in the page: data-t its text, data-h its HTML, data-l its name */
    write(root) {
      for (const e of root.querySelectorAll("[data-t]")) e.textContent = t(e.dataset.t);
      for (const e of root.querySelectorAll("[data-h]")) e.innerHTML = t(e.dataset.h);
      for (const e of root.querySelectorAll("[data-l]")) e.setAttribute("aria-label", t(e.dataset.l));
    },
  };
})();
