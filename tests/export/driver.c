/*
 * Reads samples, and prints the load, conventional load and status of each sample. NAME is the prefix of the header. The argument
 * "ticks" or "step" selects the form of the time; without it the time is in seconds. "zero" subtracts the load of sample 100 from
 * later loads. With "tare", the first line holds the mean gauges of an unloaded sensor.
 */
#include HEADER
#include <stdio.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(name) JOIN(NAME, name)

static OF(_state) state;

int main(int argc, char **argv)
{
    LOOPSCOPE_REAL gauges[GAUGES], load[AXES], conventional[AXES];
    double time, number, before = 0;
    long taken = 0;
    const char how = argc > 1 ? argv[1][0] : ' ';
    const int has_steps = how == 's', has_ticks = how == 't' && argv[1][1] == 'i', is_tared = how == 't' && !has_ticks;
    OF(_init)(&state);
    fprintf(stderr, "%lu", (unsigned long)sizeof state);
    while (scanf("%lf", &time) == 1) {
        int i, status;
        for (i = 0; i < GAUGES; i++) {
            if (scanf("%lf", &number) != 1)
                return 1;
            gauges[i] = (LOOPSCOPE_REAL)number;
        }
        taken += 1;
        if (is_tared && taken == 1) {
            OF(_tare)(&CALIBRATION, &state, gauges);
            continue;
        }
        if (has_steps)
            status = (int)OF(_update_step)(&CALIBRATION, &state, (LOOPSCOPE_REAL)(time - before), gauges, load, conventional);
        else if (has_ticks)
            status = (int)OF(_update_ticks)(&CALIBRATION, &state, (uint32_t)(uint64_t)(time * LOOPSCOPE_TICKS_PER_SECOND + 0.5), gauges, load, conventional);
        else
            status = (int)OF(_update)(&CALIBRATION, &state, time, gauges, load, conventional);
        before = time;
        for (i = 0; i < AXES; i++)
            printf("%.17g ", (double)load[i]);
        for (i = 0; i < AXES; i++)
            printf("%.17g ", (double)conventional[i]);
        printf("%d\n", status);
        if (how == 'z' && taken == 100)
            OF(_zero_last_load)(&state);
    }
    return 0;
}
