/* What encoder/input/names.h reads from the paths of images.
 *
 * SPDX-License-Identifier: MIT
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "encoder/input/names.h"

#include <stdio.h>

static void expect(const char *path, double tl, double pl, double tv, double pv) {
    enc_angles a = {-1, -1, -1, -1};
    if (!enc_names_parse(path, &a) || a.theta_light != tl || a.phi_light != pl || a.theta_view != tv ||
        a.phi_view != pv)
        fail_msg("\"%s\" gave tl %g pl %g tv %g pv %g", path, a.theta_light, a.phi_light, a.theta_view,
                 a.phi_view);
}

static void expect_none(const char *path) {
    enc_angles a;
    if (enc_names_parse(path, &a))
        fail_msg("\"%s\" gave tl %g pl %g tv %g pv %g", path, a.theta_light, a.phi_light, a.theta_view,
                 a.phi_view);
}

static void test_laboratories(void **state) {
    (void)state;
    expect("00008 tl000 pl000 tv030 pv030.jpg", 0, 0, 30, 30);
    expect("UBO2003/MANYFILES/tv000_pv000/00567 tl075 pl345 tv000 pv000.jpg", 75, 345, 0, 0);
    expect("tl015_pl060_tv045_pv340.exr", 15, 60, 45, 340);
    expect("tv11_pv7.5_tl23.5_pl-15.png", 23.5, 15, 11, 7.5);
}

static void test_order_and_separators(void **state) {
    (void)state;
    expect("pv4tv3pl2tl1.png", 1, 2, 3, 4);
    expect("TL01 Pl_02-tV=03 - PV--04.PNG", 1, 2, 3, -4);
    expect("tl1pl2tv3pv4", 1, 2, 3, 4);
    expect("x_tl_1__pl__2_tv_-_3_pv_4_take5.hdr", 1, 2, 3, 4);
    expect("2003-tl001-pl002-tv003-pv004-05.jpg", 1, 2, 3, 4);
}

static void test_sign(void **state) {
    (void)state;
    expect("tl10 pl -30 tv20 pv_-7.5.exr", 10, -30, 20, -7.5);
    expect("tl-10_pl-30_tv-20_pv-7.exr", 10, 30, 20, 7);
}

static void test_decimals(void **state) {
    (void)state;
    expect("tl7.5 pl0.25 tv22.50 pv359.999.jpg", 7.5, 0.25, 22.5, 359.999);
    expect("pl1 tv2 pv3 tl000.jpg", 0, 1, 2, 3);
    expect("pl1 tv2 pv3 tl000.5.jpg", 0.5, 1, 2, 3);
    expect("pl1 tv2 pv3 tl30.5", 30.5, 1, 2, 3);
    expect("tl1.pl2.tv3.pv4.exr", 1, 2, 3, 4);
}

static void test_folders(void **state) {
    (void)state;
    expect("tv030_pv060/tl015 pl090.png", 15, 90, 30, 60);
    expect("a/tv30/pv60/b/tl15/pl90/image.png", 15, 90, 30, 60);
    /* the file name outranks folders, near folders far ones */
    expect("tl1 pl1 tv1 pv1/tv2/tl3 pl4.png", 3, 4, 2, 1);
    expect("tv000_pv000/00001 tl000 pl000 tv075 pv015.jpg", 0, 0, 75, 15);
    /* a folder's name has no extension */
    expect("set.tv30/pv60.x/tl15 pl90.png", 15, 90, 30, 60);
}

static void test_refused(void **state) {
    (void)state;
    expect_none("");
    expect_none("/");
    expect_none("tl000 pl000 tv030.jpg");
    expect_none("00008.jpg");
    expect_none("tl pl tv pv.jpg");
    expect_none("tl1234567890 pl2 tv3 pv4.jpg"); /* no angle has ten digits */
    expect("tl00000000000001 pl2 tv3 pv4.jpg", 1, 2, 3, 4);
    expect_none("atl1 bpl2 ctv3 dpv4.jpg");                 /* letters before the key */
    expect_none("tl1 pl2 tv3 pv4 tl5.jpg");                 /* two values */
    expect_none("tl1 pl2 tv3 .pv4");                        /* that is the extension */
    expect("tl1 pl2 tv3 pv4 tl001.jpg", 1, 2, 3, 4);        /* twice the same */
    expect("html5/castle tl1 pl2 tv3 pv4.jpg", 1, 2, 3, 4); /* no key in "castle" */
}

static void test_extensions(void **state) {
    (void)state;
    assert_true(enc_names_is_image("a/b.jpg"));
    assert_true(enc_names_is_image("b.JPEG"));
    assert_true(enc_names_is_image("tl7.5.png"));
    assert_true(enc_names_is_image("b.exr"));
    assert_true(enc_names_is_image("b.HDR"));
    assert_false(enc_names_is_image("b.txt"));
    assert_false(enc_names_is_image("jpg"));
    assert_false(enc_names_is_image("a.jpg/b"));
    assert_false(enc_names_is_image("__MACOSX/._b.jpg"));
    assert_false(enc_names_is_image(""));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_laboratories), cmocka_unit_test(test_order_and_separators),
        cmocka_unit_test(test_sign),         cmocka_unit_test(test_decimals),
        cmocka_unit_test(test_folders),      cmocka_unit_test(test_refused),
        cmocka_unit_test(test_extensions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
