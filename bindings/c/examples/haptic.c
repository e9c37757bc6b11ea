/* A haptic key at 1 kHz: the device tells where its key is, and gives back the force. Here the device is simulated: a mass on a motor whose force
   comes a period late, an encoder of 2 um, a finger that pulls it down with 6 N.
   cc haptic.c $(pkg-config --cflags --libs erard) -lm -o haptic */
#include <erard.h>
#include <math.h>
#include <stdio.h>

int main(void) {
    const double period_s = 1e-3, step_s = 50e-6, mass_kg = 0.05, friction_n_s_per_m = 2.0, quantum_m = 2e-6;
    ErardStatus status;
    /* The virtual coupling is the instrument's fingertip. At 1 kHz this device stands 500 N/m and 0.5 N s/m: 500 x 0.0015 + 0.5 < 2. */
    ErardInstrument *instrument = erard_instrument_builtin("concert-grand", &status);
    if (!instrument || erard_instrument_set(instrument, "finger.stiffness_N_per_m", 0, 500.0) != ERARD_STATUS_OK ||
        erard_instrument_set(instrument, "finger.damping_N_s_per_m", 0, 0.5) != ERARD_STATUS_OK) {
        fprintf(stderr, "%s\n", erard_last_error());
        return 1;
    }
    ErardAction *action = erard_action_of_instrument(instrument, step_s, &status);
    erard_instrument_free(instrument);
    if (!action) {
        fprintf(stderr, "%s\n", erard_last_error());
        return 1;
    }
    ErardReading reading = {.struct_size = sizeof reading};
    double x = 0, v = 0, before = 0, motor_n = 0, largest_n = 0, largest_m = 0;
    for (int n = 0; n < 500; n++) {
        /* The encoder, and the velocity computed from it. */
        double seen = quantum_m * floor(x / quantum_m + 0.5), seen_m_per_s = (seen - before) / period_s;
        before = seen;
        ErardInput input = {.struct_size = sizeof input, .kind = ERARD_INPUT_MOTION,
                            .position_m = seen, .velocity_m_per_s = seen_m_per_s};
        if (erard_action_advance(action, period_s, &input, &reading) < 0) {
            return 1;
        }
        /* The device, exactly enough for a drawing. */
        for (int k = 0; k < 20; k++) {
            v += (6.0 - motor_n - friction_n_s_per_m * v) / mass_kg * period_s / 20;
            x += v * period_s / 20;
        }
        motor_n = reading.finger_force_mean_n;
        if (motor_n > largest_n) largest_n = motor_n;
        if (x > largest_m) largest_m = x;
    }
    printf("%u impacts, the last at %.3f m/s; largest force %.1f N, deepest %.2f mm, at the end %.2f mm and %.2f N\n",
           reading.impact_count, reading.hammer_speed_m_per_s, largest_n, 1e3 * largest_m, 1e3 * x, motor_n);
    erard_action_free(action);
    return 0;
}
