/* SPDX-License-Identifier: MIT
 * strike.cc - the same stroke from C++: errors as exceptions, the simulation owned by a pointer.
 */
#include <cstdio>
#include <memory>
#include <stdexcept>

#include <stein/stein.h>

namespace {
struct release {
    void operator()(stein_sim *sim) const
    {
        stein_sim_destroy(sim);
    }
};
using simulation = std::unique_ptr<stein_sim, release>;

void check(stein_status status, const stein_err &err)
{
    if (status != STEIN_OK) {
        throw std::runtime_error(err.msg);
    }
}

simulation create(const stein_model &model)
{
    stein_err err;
    stein_sim *sim = nullptr;
    check(stein_sim_create(&sim, &model, nullptr, &err), err);
    return simulation(sim);
}
} // namespace

int main()
{
    try {
        stein_err err;
        double distance = 0.0;
        simulation sim = create(stein_model_stein1788);
        check(stein_set(sim.get(), "pawl.stop_shift", -0.3e-3, &err), err);
        check(stein_reset(sim.get(), &err), err);
        check(stein_run(sim.get(), 0.050, &err), err);
        check(stein_read_name(sim.get(), "string_distance", &distance, &err), err);
        std::printf("head to string after 50 ms: %.3f mm\n", 1e3 * distance);
    } catch (const std::exception &e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
}
