/* Spectra to linear Rec. 709.
 *
 * SPDX-License-Identifier: MIT
 */
#include "spectrum.h"

#include <math.h>

enum { FIRST = 380, LAST = 780 };

/* CIE standard illuminant D65, every 10 nm from 380. */
static const double d65[41] = {
    49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923,
    108.811, 109.354, 107.802, 104.79,  107.689, 104.405, 104.046, 100.0,   96.3342, 95.788,  88.6856,
    90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091,
    74.349,  61.604,  69.8856, 75.087,  63.5927, 46.4182, 66.8054, 63.3828};

static double lobe(double nm, double height, double centre, double below, double above) {
    const double t = (nm - centre) * (nm < centre ? below : above);
    return height * exp(-0.5 * t * t);
}

/* The multi-lobe fit of Wyman et al., table 1. */
static void matching(double nm, double out[3]) {
    out[0] = lobe(nm, 0.362, 442.0, 0.0624, 0.0374) + lobe(nm, 1.056, 599.8, 0.0264, 0.0323) +
             lobe(nm, -0.065, 501.1, 0.0490, 0.0382);
    out[1] = lobe(nm, 0.821, 568.8, 0.0213, 0.0247) + lobe(nm, 0.286, 530.9, 0.0613, 0.0322);
    out[2] = lobe(nm, 1.217, 437.0, 0.0845, 0.0278) + lobe(nm, 0.681, 459.0, 0.0385, 0.0725);
}

static double illuminant(int nm, bool emission) {
    if (emission) {
        return 1.0;
    }
    const int i = (nm - FIRST) / 10;
    const double t = (nm - FIRST) % 10 / 10.0;
    return i < 40 ? d65[i] + t * (d65[i + 1] - d65[i]) : d65[40];
}

void spectrum_weights(const double *nm, size_t count, bool emission, float (*weights)[3]) {
    /* XYZ to linear RGB of Rec. 709 under D65. */
    static const double to_rgb[9] = {3.24096994190,  -1.53738317757, -0.49861076029,
                                     -0.96924363628, 1.87596750151,  0.04155505741,
                                     0.05563007970,  -0.20397695889, 1.05697151424};
    double total[3] = {0, 0, 0}, luminance = 0;
    for (int pass = 0; pass < 2; pass++) { /* the sums first, then what they divide */
        for (size_t i = 0; i < count; i++) {
            double xyz[3] = {0, 0, 0};
            for (int at = FIRST; at <= LAST; at++) {
                double share = 0.0, m[3];
                if (count == 1 || (i == 0 && at <= nm[0]) || (i == count - 1 && at >= nm[i])) {
                    share = 1.0;
                } else if (i > 0 && at > nm[i - 1] && at <= nm[i]) {
                    share = (at - nm[i - 1]) / (nm[i] - nm[i - 1]);
                } else if (i < count - 1 && at > nm[i] && at < nm[i + 1]) {
                    share = (nm[i + 1] - at) / (nm[i + 1] - nm[i]);
                }
                matching(at, m);
                for (int c = 0; c < 3; c++) {
                    xyz[c] += share * m[c] * illuminant(at, emission);
                }
            }
            luminance += pass == 0 ? xyz[1] : 0.0;
            for (int c = 0; c < 3; c++) {
                const double rgb =
                    to_rgb[3 * c] * xyz[0] + to_rgb[3 * c + 1] * xyz[1] + to_rgb[3 * c + 2] * xyz[2];
                total[c] += pass == 0 ? rgb : 0.0;
                if (pass == 1) {
                    weights[i][c] = (float)(rgb / (emission ? luminance : total[c]));
                }
            }
        }
    }
}
