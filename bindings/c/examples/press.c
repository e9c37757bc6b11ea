/* A press: 5 N for a quarter of a second, and the impact that they make.
   cc press.c $(pkg-config --cflags --libs erard) -o press */
#include <erard.h>
#include <stdio.h>

int main(void) {
    ErardStatus status;
    ErardAction *action = erard_action_new(NULL, 0, 50e-6, &status);
    if (!action) {
        fprintf(stderr, "%s\n", erard_last_error());
        return 1;
    }
    ErardReading reading = {.struct_size = sizeof reading};
    for (int n = 0; n < 10000; n++) {
        if (erard_action_step_force(action, n < 5000 ? 5.0 : 0.0, &reading) < 0) {
            fprintf(stderr, "step %d\n", n);
            return 1;
        }
        if (reading.new_impact_count) {
            printf("impact at %.6f s with %.17g m/s, key %.3f mm down\n", reading.impact_time_s, reading.hammer_speed_m_per_s,
                   1e3 * reading.key_m);
        }
    }
    printf("%u impacts; the key ends at %.17g m\n", reading.impact_count, reading.key_m);
    erard_action_free(action);
    return 0;
}
