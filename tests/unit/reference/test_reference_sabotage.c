/* The self-test of the reference decoder must refuse a build that breaks FORMAT.md, section 8. This file is compiled
 * together with reference/btf_*.c, with flags that break it: -O2 -ffast-math, or -O2 -ffp-contract=fast -mfma. Exits 0
 * when the self-test refuses the build, 1 when it does not, 77 when this machine cannot run it.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/reference.h>

#include <stdio.h>

int main(void) {
#if defined __FMA__ && (defined __x86_64__ || defined __i386__)
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("fma")) {
        printf("skipped: this processor has no FMA\n");
        return 77;
    }
#endif
    if (btf_ref_self_test()) {
        printf("the self-test takes this build for sound\n");
        return 1;
    }
    printf("refused, as it should be\n");
    return 0;
}
