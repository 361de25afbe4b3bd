/*
 * Prints the mean and the longest time of an update of an exported header (microseconds). The arguments are the sample rate and the
 * kind of signal. For each update the shortest of five passes counts, because other programs interrupt the measurement.
 */
#define _POSIX_C_SOURCE 199309L
#include HEADER
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SAMPLES = 120000, PASSES = 5 };

static timed_state state;
static double shortest[SAMPLES];

static double now(void)
{
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return 1e6 * (double)at.tv_sec + 1e-3 * (double)at.tv_nsec;
}

/* Returns a pseudo-random number from -1 to 1. The sequence is the same in every run. */
static double noise(void)
{
    static unsigned long long state = 88172645463325252ull;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) / 4503599627370496.0 - 1.0;
}

/* Returns the signal of a gauge: 'v' is 67 Hz that move the load by F_th from peak to peak, 'n' is noise of the same size, 's' is a
 * step each second, and any other letter is a slow load. */
static double gauge(char signal, double time, int g)
{
    static double step[TIMED_GAUGES], until;
    double mean = timed_gauge_mean(g), deviation = timed_gauge_deviation(g), brush = timed_gauge_brush(g);
    switch (signal) {
    case 'v':
        return mean + brush * sin(2 * 3.14159265358979 * 67 * time);
    case 'n':
        return mean + brush * noise();
    case 's':
        if (time >= until || time == 0) {
            int at;
            until = time + 1;
            for (at = 0; at < TIMED_GAUGES; at++)
                step[at] = 2 * noise();
        }
        return mean + deviation * step[g];
    default:
        return mean + deviation * sin(0.7 * time + g) * cos(0.11 * time);
    }
}

int main(int argc, char **argv)
{
    timed_real load[TIMED_AXES], gauges[TIMED_GAUGES];
    double worst = 0, total = 0, sum = 0, clock = 1e9;
    double rate = argc > 1 ? atof(argv[1]) : 1000;
    char signal = argc > 2 ? argv[2][0] : 'c';
    long k;
    int pass, g;
    for (pass = 0; pass < PASSES; pass++) {
        timed_init(&state);
        for (k = 0; k < SAMPLES; k++) {
            double time = (double)k / rate, before, between, after;
            for (g = 0; g < TIMED_GAUGES; g++)
                gauges[g] = (timed_real)gauge(signal, time, g);
            before = now();
            between = now();
            timed_update(&TIMED_CALIBRATION, &state, time, gauges, load, NULL);
            after = now();
            clock = between - before < clock ? between - before : clock;
            if (pass == 0 || after - between < shortest[k])
                shortest[k] = after - between;
            sum += (double)load[0];
        }
    }
    for (k = 0; k < SAMPLES; k++) {
        double taken = shortest[k] - clock;
        total += taken;
        worst = taken > worst ? taken : worst;
    }
    printf("mean %.2f us, worst %.1f us, %lu bytes (sum of loads %g)\n", total / SAMPLES, worst, (unsigned long)sizeof state, sum);
    return 0;
}
