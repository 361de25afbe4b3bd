/* Times updates of an exported header at 1 kHz: mean and worst, in microseconds. */
#define _POSIX_C_SOURCE 199309L
#include HEADER
#include <stdio.h>
#include <time.h>

static timed_state state;

static double now(void)
{
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return 1e6 * (double)at.tv_sec + 1e-3 * (double)at.tv_nsec;
}

int main(void)
{
    enum { SAMPLES = 120000 };
    timed_real load[TIMED_AXES], gauges[TIMED_GAUGES];
    double worst = 0, total = 0, sum = 0;
    long k;
    timed_init(&state);
    for (k = 0; k < SAMPLES; k++) {
        double time = 1e-3 * (double)k, before, taken;
        int g;
        for (g = 0; g < TIMED_GAUGES; g++)
            gauges[g] = (timed_real)(timed_gauge_mean(g) + timed_gauge_deviation(g) * sin(0.7 * time + g) * cos(0.11 * time));
        before = now();
        timed_update(&TIMED_CALIBRATION, &state, time, gauges, load, NULL);
        taken = now() - before;
        total += taken;
        worst = taken > worst ? taken : worst;
        sum += (double)load[0];
    }
    printf("mean %.3f us, worst %.1f us, clock alone included (%g)\n", total / SAMPLES, worst, sum);
    return 0;
}
