/* Angles that encoder/input/names.h reads from the paths of images.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/input/names.h"
#include "tests/support/test.h"

/* Reads a name as if it were the only one of its data set. */
static enc_name_verdict parse_alone(const char *path, enc_name *name, enc_angles *angles) {
    const enc_name_verdict verdict = enc_names_parse(path, name);
    *angles = enc_names_angles(name, name->is_plain);
    return verdict;
}

static void expect(const char *path, double tl, double pl, double tv, double pv) {
    enc_name name;
    enc_angles a;
    if (parse_alone(path, &name, &a) != ENC_NAME_READ || a.theta_light != tl || a.phi_light != pl ||
        a.theta_view != tv || a.phi_view != pv) {
        fail_msg("\"%s\" gave tl %g pl %g tv %g pv %g, %s", path, a.theta_light, a.phi_light, a.theta_view,
                 a.phi_view, name.why ? name.why : "no complaint");
    }
}

static void expect_none(const char *path) {
    enc_name name;
    enc_angles a;
    if (parse_alone(path, &name, &a) != ENC_NAME_INCOMPLETE) {
        fail_msg("\"%s\" gave tl %g pl %g tv %g pv %g, %s", path, a.theta_light, a.phi_light, a.theta_view,
                 a.phi_view, name.why ? name.why : "no complaint");
    }
}

/* The name has all four angles, one of which is ambiguous: it is refused with these words. */
static void expect_bad(const char *path, const char *bad, const char *why) {
    enc_name name;
    enc_angles a;
    if (parse_alone(path, &name, &a) != ENC_NAME_BAD || strcmp(name.bad, bad) != 0 ||
        !strstr(name.why, why)) {
        fail_msg("\"%s\" gave tl %g pl %g tv %g pv %g, '%s', %s", path, a.theta_light, a.phi_light,
                 a.theta_view, a.phi_view, name.bad, name.why ? name.why : "no complaint");
    }
}

TEST(test_laboratories) {
    expect("00008 tl000 pl000 tv030 pv030.jpg", 0, 0, 30, 30);
    expect("UBO2003/MANYFILES/tv000_pv000/00567 tl075 pl345 tv000 pv000.jpg", 75, 345, 0, 0);
    expect("tl015_pl060_tv045_pv340.exr", 15, 60, 45, 340);
    expect("tv11_pv7.5_tl23.5_pl-15.png", 23.5, -15, 11, 7.5);
}

TEST(test_order_and_separators) {
    expect("pv4tv3pl2tl1.png", 1, 2, 3, 4);
    expect("TL01 Pl_02-tV=03 - PV--04.PNG", 1, 2, 3, -4);
    expect("tl1pl2tv3pv4", 1, 2, 3, 4);
    expect("x_tl_1__pl__2_tv_-_3_pv_4_take5.hdr", 1, 2, 3, 4);
    expect("2003-tl001-pl002-tv003-pv004-05.jpg", 1, 2, 3, 4);
}

TEST(test_sign) {
    expect("tl10 pl -30 tv20 pv_-7.5.exr", 10, -30, 20, -7.5);
    expect("tl+10 pl+30 tv20 pv=+7.exr", 10, 30, 20, 7);
    expect("tl10 pl\u221230 tv20 pv_\u22127.exr", 10, -30, 20, -7);
    expect("tl10 pl\uff0d30 tv20 pv7.exr", 10, -30, 20, 7);
    /* a dash behind every key is a separator; behind some, a minus */
    expect("tl-10_pl-30_tv-20_pv-7.exr", 10, 30, 20, 7);
    expect("tl-10_pl--30_tv-20_pv-7.exr", 10, -30, 20, 7);
    expect("tl10_pl30_tv20_pv-7.exr", 10, 30, 20, -7);
    expect("tl_10_pl_30_tv_20_pv-7.exr", 10, 30, 20, -7);
    expect("tv20_pv-0/tl0 pl0.png", 0, 0, 20, 0);
    /* dashes of typography may be either */
    expect_bad("tl10 pl\u201330 tv20 pv7.exr", "pl\u201330 tv20 pv7", "dash");
    expect_bad("tl10 pl\u201030 tv20 pv7.exr", "pl\u201030 tv20 pv7", "dash");
}

/* Another name of the set may tell that a dash is a minus. */
TEST(test_sign_of_a_set) {
    enc_name dashed, plain;
    assert_int_equal(enc_names_parse("tl-10_pl-30_tv-20_pv-7.exr", &dashed), ENC_NAME_READ);
    assert_int_equal(enc_names_parse("tl10_pl30_tv20_pv7.exr", &plain), ENC_NAME_READ);
    assert_false(dashed.is_plain);
    assert_true(plain.is_plain);
    const enc_angles a = enc_names_angles(&dashed, true);
    assert_true(a.theta_light == -10 && a.phi_light == -30 && a.theta_view == -20 && a.phi_view == -7);
}

TEST(test_numbers) {
    expect("tl22,5 pl22p5 tv3.5e-15 pv1.5E+2.png", 22.5, 22.5, 3.5 / 1e15, 150);
    expect("tl22p5pl30tv22P5pv0.png", 22.5, 30, 22.5, 0);
    expect("tl.5 pl.25 tv0 pv0.png", 0.5, 0.25, 0, 0);
    expect("tl30deg_pl45\u00b0_tv20Degrees_pv7degree.png", 30, 45, 20, 7);
    expect("tl30\u00b0pl45\u00batv20\u02dapv7.png", 30, 45, 20, 7);
    expect("tl30,pl45;tv20,pv7.png", 30, 45, 20, 7);
    expect("[tl30](pl45){tv20}pv7.png", 30, 45, 20, 7);
    expect("tl\u00a030\u00a0pl\u00a045 tv20 pv7.png", 30, 45, 20, 7);
    expect("tl7.1234567890123 pl0 tv0 pv0.png", 7.1234567890123, 0, 0, 0);
    expect_bad("tl22_5_pl30 tv0 pv0.png", "tl22_5_pl30 tv0 pv0", "decimals");
    expect_bad("tl22-5-pl30 tv0 pv0.png", "tl22-5-pl30 tv0 pv0", "decimals");
    expect_bad("tl1.2.3 pl0 tv0 pv0.png", "tl1.2.3 pl0 tv0 pv0", "not one number");
    expect_bad("tl1,2,3 pl0 tv0 pv0.png", "tl1,2,3 pl0 tv0 pv0", "not one number");
    expect_bad("tl1+2 pl0 tv0 pv0.png", "tl1+2 pl0 tv0 pv0", "not one number");
    expect_bad("tl30:15 pl0 tv0 pv0.png", "tl30:15 pl0 tv0 pv0", "not one number");
    expect_bad("tl0x1f pl0 tv0 pv0.png", "tl0x1f pl0 tv0 pv0", "part of the number");
    expect_bad("tl22 5 pl30 tv0 pv0.png", "tl22 5 pl30 tv0 pv0", "decimals");
    expect_bad("tl22__5_pl30 tv0 pv0.png", "tl22__5_pl30 tv0 pv0", "decimals");
    expect_bad("tl22 .5 pl30 tv0 pv0.png", "tl22 .5 pl30 tv0 pv0", "decimals");
    expect_bad("tl22~5 pl30 tv0 pv0.png", "tl22~5 pl30 tv0 pv0", "decimals");
    expect_bad("tl22(5)pl30 tv0 pv0.png", "tl22(5)pl30 tv0 pv0", "decimals");
    expect_bad("tl22.,5 pl30 tv0 pv0.png", "tl22.,5 pl30 tv0 pv0", "not one number");
    expect("tl30degpl60degtv15degpv7.png", 30, 60, 15, 7);
    /* a point behind one key is decimal, behind every key it may separate */
    expect_bad("tl.30_pl.60_tv.15_pv.30.png", "tl.30_pl.60_tv.15_pv.30.png", "separators");
    expect("tl.5_pl.5_tv.5_pv0.png", 0.5, 0.5, 0.5, 0);
    expect("tl_.5_pl_.5_tv_.5_pv_.5.png", 0.5, 0.5, 0.5, 0.5);
    expect_bad("tl1f pl0 tv0 pv0.png", "tl1f pl0 tv0 pv0", "part of the number");
    expect_bad("tl30'15 pl0 tv0 pv0.png", "tl30'15 pl0 tv0 pv0", "part of the number");
    expect_bad("tl22%2E5 pl0 tv0 pv0.png", "tl22%2E5 pl0 tv0 pv0", "part of the number");
    expect_bad("tl22\u00bd pl0 tv0 pv0.png", "tl22\u00bd pl0 tv0 pv0", "part of the number");
    expect_bad("tl3e1 pl0 tv0 pv0.png", "tl3e1 pl0 tv0 pv0", "part of the number");
    expect_bad("tl3e-x pl0 tv0 pv0.png", "tl3e-x pl0 tv0 pv0", "exponent");
    expect_bad("tl3e+99 pl0 tv0 pv0.png", "tl3e+99 pl0 tv0 pv0", "too large");
    expect_bad("tl0.5rad pl0 tv0 pv0.png", "tl0.5rad pl0 tv0 pv0", "degrees only");
    expect_bad("tl50gon pl0 tv0 pv0.png", "tl50gon pl0 tv0 pv0", "degrees only");
    expect_bad("pl5/tl30 plm60 tv15 pv30.png", "plm60 tv15 pv30", "sign");
    expect_bad("pl5/tl30 pl~60 tv15 pv30.png", "pl~60 tv15 pv30", "sign");
    expect_bad("pl5/tl30 pl(60) tv15 pv30.png", "pl(60) tv15 pv30", "sign");
    expect("plm2_tl30_pl60_tv15_pv30.png", 30, 60, 15, 30); /* another word */
    expect("tl30_pl60_tv15_pv30_plm2.png", 30, 60, 15, 30);
    /* a folder's tv is no substitute for a faulty one, and does no harm where it is not needed */
    expect_bad("tv5/tl0 pl0 tv22x5 pv0.png", "tv22x5 pv0", "part of the number");
    expect("tv22x5/tl0 pl0 tv5 pv0.png", 0, 0, 5, 0);
}

TEST(test_doubts) {
    static const struct {
        const char *path;
        bool counter, differs, frame;
    } cases[] = {
        {"tl1 pl2 tv3 pv4.png", false, false, false},
        {"tl1_pl2_tv3_pv7_5.png", true, false, false},
        {"tl1-pl2-tv3-pv4-05.png", true, false, false},
        {"tl1_pl2_tv3_pv4_take5.png", false, false, false},
        {"tv3_pv4/tl1 pl2 tv3.0 pv4.png", false, false, false},
        {"tv30_pv4/tl1 pl2 tv3 pv4.png", false, true, false},
        {"tv3_pv4_2/tl1 pl2.png", true, false, false},
        {"tl1 pl2 tv3 pv4 0001.png", true, false, false},
        {"tl1 pl2 tv3 pv4 (1).png", true, false, false},
        {"tl1 pl2 tv3 pv4(1).png", true, false, false},
        {"tl1 pl2 tv3 pv4 - Copy.png", false, false, false},
        {"tl1 pl2 tv3 pv4_v2.png", false, false, false},
        {"tl1_pl2_tv3_pv4.0105.png", false, false, true},
        {"tl1_pl2_tv3_pv4p1.png", false, false, true},
        {"tl1_pl2_tv3_pv4.5.png", false, false, false},
        {"tl1_pl2_tv3_pv4.000.png", false, false, false},
        {"tl1.5_pl2_tv3_pv4.0105.png", false, false, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        enc_name name;
        assert_int_equal(enc_names_parse(cases[i].path, &name), ENC_NAME_READ);
        if (name.counter != cases[i].counter || name.folders_differ != cases[i].differs ||
            name.like_frame != cases[i].frame) {
            fail_msg("%s: counter %d, differs %d, frame %d", cases[i].path, name.counter,
                     name.folders_differ, name.like_frame);
        }
    }
}

TEST(test_number) {
    double x = 0;
    assert_true(enc_names_number("-7.5", false, &x) && x == -7.5);
    assert_true(enc_names_number("+1e-2", false, &x) && x == 0.01);
    assert_true(enc_names_number("22,5", true, &x) && x == 22.5);
    assert_true(enc_names_number("\u221230\u00b0", false, &x) && x == -30);
    assert_true(enc_names_number("30.", false, &x) && x == 30);
    assert_true(enc_names_number("31 \u00b0", false, &x) && x == 31);
    assert_true(enc_names_number("32\xb0", false, &x) && x == 32);
    static const char *const wrong[] = {"",   "-",   "x",   "1x",  "1 2", "22,5", "1 -",
                                        "1 ", "nan", "inf", "0x1", "1e",  "--1",  "1rad"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        if (enc_names_number(wrong[i], false, &x)) {
            fail_msg("\"%s\" gave %g", wrong[i], x);
        }
    }
}

TEST(test_units) {
    static const struct {
        enc_angles angles[2];
        enc_radians radians;
        size_t beyond;
    } cases[] = {
        {{{30, 6, 0.5, 0}, {0, 0, 0, 0}}, ENC_RADIANS_NONE, 0},
        {{{0.5236, 3.1416, 0, 0}, {0, 0, 1.0472, -6.2}}, ENC_RADIANS_ALL, 0},
        {{{0.5, 3.1416, 0, 0}, {1, 1.5708, 0.5, 1.5708}}, ENC_RADIANS_ALL, 0}, /* one of them is whole */
        {{{0, 0, 0, 0}, {0, 0, 0, 0}}, ENC_RADIANS_NONE, 0}, /* no direction but the pole */
        {{{5, 0, 0.5, 0}, {0, 0, 0, 0}}, ENC_RADIANS_NONE, 0},
        {{{30, 1.5708, 15, 3.1416}, {0, 0, 45, 0}}, ENC_RADIANS_PHI, 0},
        {{{0.5236, 90, 0.2618, 180}, {0, 0, 1.0472, 0}}, ENC_RADIANS_THETA, 0},
        {{{50, 399, 0, -361}, {50, 360, 0, 0}}, ENC_RADIANS_NONE, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        enc_angle_range range = {.beyond = 0};
        enc_angles_survey(&range, &cases[i].angles[0]);
        enc_angles_survey(&range, &cases[i].angles[1]);
        assert_int_equal(enc_angles_look_like_radians(&range), cases[i].radians);
        assert_int_equal(range.beyond, cases[i].beyond);
    }
}

TEST(test_decimals) {
    expect("tl7.5 pl0.25 tv22.50 pv359.999.jpg", 7.5, 0.25, 22.5, 359.999);
    expect("pl1 tv2 pv3 tl000.jpg", 0, 1, 2, 3);
    expect("pl1 tv2 pv3 tl000.5.jpg", 0.5, 1, 2, 3);
    expect("pl1 tv2 pv3 tl30.5", 30.5, 1, 2, 3);
    expect("tl1.pl2.tv3.pv4.exr", 1, 2, 3, 4);
}

TEST(test_folders) {
    expect("tv030_pv060/tl015 pl090.png", 15, 90, 30, 60);
    expect("set\\tv030_pv060\\tl015 pl090.png", 15, 90, 30, 60); /* of an archive made by Windows */
    expect("a/tv30/pv60/b/tl15/pl90/image.png", 15, 90, 30, 60);
    /* the file name outranks folders, near folders far ones */
    expect("tl1 pl1 tv1 pv1/tv2/tl3 pl4.png", 3, 4, 2, 1);
    expect("tv000_pv000/00001 tl000 pl000 tv075 pv015.jpg", 0, 0, 75, 15);
    /* a folder's name has no extension */
    expect("set.tv30/pv60.x/tl15 pl90.png", 15, 90, 30, 60);
}

TEST(test_refused) {
    expect_none("");
    expect_none("/");
    expect_none("tl000 pl000 tv030.jpg");
    expect_none("00008.jpg");
    expect_none("tl pl tv pv.jpg");
    expect_bad("tl1234567890 pl2 tv3 pv4.jpg", "tl1234567890 pl2 tv3 pv4", "ten digits");
    expect("tl00000000000001 pl2 tv3 pv4.jpg", 1, 2, 3, 4);
    expect_none("atl1 bpl2 ctv3 dpv4.jpg");                 /* letters before the key */
    expect_none("tl1 pl2 tv3 pv4 tl5.jpg");                 /* two values */
    expect_none("tl1 pl2 tv3 .pv4");                        /* that is the extension */
    expect("tl1 pl2 tv3 pv4 tl001.jpg", 1, 2, 3, 4);        /* twice the same */
    expect("html5/castle tl1 pl2 tv3 pv4.jpg", 1, 2, 3, 4); /* no key in "castle" */
}

TEST(test_extensions) {
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
    assert_true(enc_names_is_image("./a/../b.jpg"));
    assert_false(enc_names_is_image(".thumbs/b.jpg"));
    assert_false(enc_names_is_image("set/__MACOSX/b.jpg"));
    assert_false(enc_names_is_image("set\\__MACOSX\\b.jpg"));
    assert_false(enc_names_is_image("Thumbs.db"));
    assert_true(enc_names_is_foreign_image("b.TIF"));
    assert_false(enc_names_is_foreign_image("b.png"));
    assert_false(enc_names_is_foreign_image("._b.tif"));
}

RUN_TESTS(NULL, NULL)
