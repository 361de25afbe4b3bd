/* Reads samples, prints load, conventional load and status of each. NAME is the prefix of the header. */
#include HEADER
#include <stdio.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(name) JOIN(NAME, name)

static OF(_state) state;

int main(int argc, char **argv)
{
    LOOPSCOPE_REAL gauges[GAUGES], load[AXES], conventional[AXES];
    double time, number;
    long taken = 0;
    (void)argv;
    OF(_init)(&state);
    fprintf(stderr, "%lu", (unsigned long)sizeof state);
    while (scanf("%lf", &time) == 1) {
        int i, status;
        for (i = 0; i < GAUGES; i++) {
            if (scanf("%lf", &number) != 1)
                return 1;
            gauges[i] = (LOOPSCOPE_REAL)number;
        }
        status = (int)OF(_update)(&CALIBRATION, &state, time, gauges, load, conventional);
        for (i = 0; i < AXES; i++)
            printf("%.17g ", (double)load[i]);
        for (i = 0; i < AXES; i++)
            printf("%.17g ", (double)conventional[i]);
        printf("%d\n", status);
        taken += 1;
        if (argc > 1 && taken == 100)
            OF(_zero_last_load)(&state);
    }
    return 0;
}
