/* The meaning of angles in file names, or in a table of names, that only the whole data set tells
 * (encoder/input/grid.h, names_table.h): signs, noise, units, contradictions.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/png_image.h"
#include "tests/support/image_files.h"
#include "tests/support/image_set.h"
#include "tests/support/test.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *path_in(const char *name) {
    static char path[PATH];
    snprintf(path, sizeof path, "%s/%s", temporary_folder, name);
    return path;
}

static void write_image(int v, int l, const char *name) {
    unsigned char codes[W * H * 3];
    set_make_codes(v, l, codes);
    assert_int_equal(png_image_write8(path_in(name), W, H, codes, set_no_log), BTF_OK);
}

/* Writes the set of image_set.h, with names by a format of tv, pv, tl, pl. */
static void write_set(const char *format, double scale) __attribute__((format(printf, 1, 0)));
static void write_set(const char *format, double scale) {
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            char name[128];
            snprintf(name, sizeof name, format, set_views[v][0] * scale, set_views[v][1] * scale,
                     set_lights[l][0] * scale, set_lights[l][1] * scale);
            write_image(v, l, name);
        }
    }
}

static void write_text(const char *name, const char *text) {
    write_whole_file(path_in(name), text, strlen(text));
}

static const enc_read_options plain = {0};

static void expect_said(const char *word) {
    if (!strstr(all_messages, word)) {
        fail_msg("\"%s\" does not say \"%s\"", all_messages, word);
    }
}

/* Reads the set and finds it as it should be. Messages are kept for expect_said. */
static void expect_whole(const enc_read_options *options) {
    all_messages[0] = '\0';
    enc_data *data = set_read_folder(options);
    set_expect(data, 1e-7);
    enc_data_destroy(&data);
}

static void expect_silent(const enc_read_options *options) {
    expect_whole(options);
    assert_string_equal(all_messages, "");
}

static void write_azimuths_from_minus_180(void) {
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            const double pv = remainder(set_views[v][1], 360), pl = remainder(set_lights[l][1], 360);
            char name[128];
            snprintf(name, sizeof name, "tv%g_pv%g_tl%g_pl%g.png", set_views[v][0], pv, set_lights[l][0],
                     pl);
            write_image(v, l, name);
        }
    }
}

SET_TEST(test_negative) {
    write_azimuths_from_minus_180();
    expect_silent(&plain);
}

/* A dash after every key of every name is a separator. Where one name lacks it, dashes are minus signs, and then a
 * theta below 0 is refused and not read without its sign. */
SET_TEST(test_dashes) {
    write_set("tv-%g-pv-%g-tl-%g-pl-%g.png", 1);
    expect_silent(&plain);
    write_image(0, 0, "tv10_pv0_tl0_pl0.png");
    set_expect_refused(temporary_folder, &plain, BTF_ERROR_BAD_FILE, "theta -",
                       "the dash is read as a minus", NULL);
}

/* Where every name has a dash after the same key, it is taken for a minus with a warning. */
SET_TEST(test_dash_behind_one_key) {
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            char name[128];
            snprintf(name, sizeof name, "tv%g_pv-%g_tl%g_pl%g.png", set_views[v][0],
                     fmod(360 - set_views[v][1], 360), set_lights[l][0], set_lights[l][1]);
            write_image(v, l, name);
        }
    }
    expect_whole(&plain);
    expect_said("images have a dash behind the key pv, which is read as a minus");
}

/* A frame number after a point gives a warning, as it cannot be distinguished from decimals. */
SET_TEST(test_frames) {
    write_set("tv%03.0f_pv%03.0f_tl%03.0f_pl%03.0f.0001.png", 1);
    enc_data *data = set_read_folder(&plain);
    expect_said("the last angle alone has decimals: are they a frame number?");
    enc_data_destroy(&data);
}

SET_TEST(test_noise) {
    static const double noise[] = {0, 4e-15, -4e-15, 5e-4, -4e-4};
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            const double n = l == 0 && v == 0 ? 0 : noise[(v + l) % 5];
            char name[128];
            snprintf(name, sizeof name, "tv%.17g_pv%.17g_tl%.17g_pl%.17g.png", fabs(set_views[v][0] + n),
                     v == 0 ? 0 : fmod(360 + set_views[v][1] + n, 360), fabs(set_lights[l][0] + n),
                     l == 0 ? 0 : fmod(360 + set_lights[l][1] + n, 360));
            write_image(v, l, name);
        }
    }
    expect_silent(&plain);
}

SET_TEST(test_decimals) {
    char name[128];
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            snprintf(name, sizeof name, "tv%03.1f_pv%03.1f_tl%03.1f_pl%03.1f", set_views[v][0],
                     set_views[v][1], set_lights[l][0], set_lights[l][1]);
            for (char *p = name; *p; p++) {
                *p = *p == '.' ? (v % 2 ? ',' : 'p') : *p;
            }
            write_image(v, l, strcat(name, ".png"));
        }
    }
    expect_silent(&plain);
    write_image(0, 0, "tv22_5_pv0_tl0_pl0.png");
    set_expect_refused(temporary_folder, &plain, BTF_ERROR_BAD_FILE, "1 images have an angle",
                       "tv22_5_pv0_tl0_pl0.png", "decimals", "option names", NULL);
}

SET_TEST(test_radians) {
    write_set("tv%.4f_pv%.4f_tl%.4f_pl%.4f.png", M_PI / 180);
    enc_data *data = set_read_folder(&plain);
    expect_said("look like radians");
    expect_said("first is tv0.0000_pv0.0000_tl0.2618_pl1.5708.png");
    enc_data_destroy(&data);
}

SET_TEST(test_indices) {
    for (int v = 0; v < 3; v++) {
        for (int l = 0; l < 3; l++) {
            char name[128];
            snprintf(name, sizeof name, "tv%d_pv%d_tl%d_pl%d.png", v, v * 2, l, l * 3);
            write_image(v, l, name);
        }
    }
    enc_data *data = set_read_folder(&plain);
    expect_said("all thetas are whole and below 10: they look like numbers of directions");
    enc_data_destroy(&data);
}

SET_TEST(test_gradians) {
    write_set("tv%.4f_pv%.4f_tl%.4f_pl%.4f.png", 1 / 0.9);
    enc_data *data = set_read_folder(&plain);
    expect_said("4 azimuths lie beyond 360 degrees");
    enc_data_destroy(&data);
}

SET_TEST(test_contradictions) {
    write_set("tv%03g_pv%03g_tl%03g_pl%03g_01.png", 1);
    expect_whole(&plain);
    expect_said("20 images have digits behind their last angle");
    assert_int_equal(mkdir(path_in("tv15"), 0777), 0);
    char from[PATH];
    snprintf(from, sizeof from, "%s", path_in("tv030_pv000_tl000_pl000_01.png"));
    assert_int_equal(rename(from, path_in("tv15/tv030_pv000_tl000_pl000_01.png")), 0);
    expect_whole(&plain);
    expect_said("1 images lie in folders whose names give other angles");
    expect_said("tv15/tv030_pv000_tl000_pl000_01.png");
    write_text("tv0_pv0_tl0_pl0.TIFF", "x");
    expect_whole(&plain);
    expect_said("1 files of image formats that are not read are left out: first is tv0_pv0_tl0_pl0.TIFF");
}

SET_TEST(test_elevation) {
    write_image(0, 0, "tv90_pv0_tl30_pl0.png");
    set_expect_refused(temporary_folder, &plain, BTF_ERROR_BAD_FILE, "theta 90 of the view",
                       "not the elevation", NULL);
}

/* Writes the images as NNN.png, and a table of them with a line format of file, tv, pv, tl, pl. */
static void write_table(const char *table, const char *head, const char *format)
    __attribute__((format(printf, 3, 0)));
static void write_table(const char *table, const char *head, const char *format) {
    FILE *file = fopen(path_in(table), "w");
    assert_non_null(file);
    fputs(head, file);
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            char name[32];
            snprintf(name, sizeof name, "%03d.png", v * LIGHTS + l);
            write_image(v, l, name);
            fprintf(file, format, name, set_views[v][0], set_views[v][1], set_lights[l][0],
                    set_lights[l][1]);
        }
    }
    assert_int_equal(fclose(file), 0);
}

static const enc_read_options *by_table(void) {
    static char path[PATH];
    static enc_read_options options;
    snprintf(path, sizeof path, "%s/table.csv", temporary_folder);
    options = (enc_read_options){.names = path};
    return &options;
}

SET_TEST(test_tables) {
    static const struct {
        const char *head, *format;
    } cases[] = {
        {"", "%s,%g,%g,%g,%g\n"},
        {"", "%s %g %g %g %g\n"},
        {"\n# by hand\n", "  %s   %g  %g %g  %g  \r\n"},
        {"\xef\xbb\xbf"
         "file,theta_v,phi_v,theta_l,phi_l\r\n",
         "\"%s\", %g, %g, %g, %g,,\r\n"},
        {"Image Name;Theta_V [deg];Phi_V [deg];ThetaL (deg);PhiL (deg)\n", "%s;%.1f;%.1f;%.1f;%.1f\n"},
        {"sep=;\n", "%s;%g;%g;%g;%g\n"},
        {"SEP=,\n", "%s,%g,%g,%g,%g\n,,,,\n"},
        {"# file, theta_o, phi_o, theta_i, phi_i\n", "%s,%g,%g,%g,%g\n"},
        {"", "%s\t%g\t%g\t%g\t%g\r"},
        {"", ".\\%s\t%g\xc2\xb0\t%g\t+%g\t%g\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_table("table.csv", cases[i].head, cases[i].format);
        expect_silent(by_table());
    }
}

/* Spreadsheets with decimal commas that separate fields by commas all the same put quotes around such numbers. */
SET_TEST(test_quoted_commas) {
    write_table("table.csv", "file,tv,pv,tl,pl\n", "%s,\"%.1f\",\"%.1f\",\"%.1f\",\"%.1f\"\n");
    char text[4096] = "";
    FILE *file = fopen(path_in("table.csv"), "r");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    fclose(file);
    for (char *p = text; *p; p++) {
        if (*p == '.' && p[2] == '"') {
            *p = ',';
        }
    }
    write_text("table.csv", text);
    expect_silent(by_table());
}

/* The folder of the set may be named as it was given, though it is a link. */
SET_TEST(test_table_through_link) {
    char link[PATH + 8], format[2 * PATH];
    snprintf(link, sizeof link, "%s.link", temporary_folder);
    assert_int_equal(symlink(temporary_folder, link), 0);
    snprintf(format, sizeof format, "%s/%%s,%%g,%%g,%%g,%%g\n", link);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    write_table("table.csv", "", format);
#pragma GCC diagnostic pop
    enc_data *data = NULL;
    assert_int_equal(enc_read(&set_context, link, by_table(), &data), BTF_OK);
    set_expect(data, 1e-7);
    enc_data_destroy(&data);
    unlink(link);
}

/* Headings give columns another order, and decimal commas are read where ';' separates. */
SET_TEST(test_headings) {
    FILE *file = fopen(path_in("table.csv"), "w");
    fputs("# pl; tl ;note; file; pv; tv\n", file);
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            char name[32], line[200];
            snprintf(name, sizeof name, "a #%d; b.png", v * LIGHTS + l);
            write_image(v, l, name);
            snprintf(line, sizeof line, "%g;%g;\"say \"\"x\"\"\";\"%s\";%g;%g\n", set_lights[l][1],
                     set_lights[l][0], name, set_views[v][1], set_views[v][0]);
            for (char *p = line; (p = strstr(p, "7.5"));) {
                p[1] = ',';
            }
            fputs(line, file);
        }
    }
    fclose(file);
    expect_silent(by_table());
    write_text("table.csv", "# file, theta_l, phi_l, theta_v, azimuth\na.png,0,0,0,0\n");
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE, "table.csv: line 1",
                       "no column phi_v", NULL);
    write_text("table.csv", "file,theta_l,phi_l,theta_v,azimuth\na.png,0,0,0,0\n");
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE, "table.csv: line 1",
                       "no column phi_v", NULL);
    write_text("table.csv", "file,theta_v_rad,phi_v,theta_l,phi_l\na.png,0,0,0,0\n");
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE, "table.csv: line 1",
                       "no column theta_v", NULL);
}

SET_TEST(test_table_and_files) {
    write_table("table.csv", "nowhere.png,0,0,0,0\n", "%s,%g,%g,%g,%g\n");
    write_image(0, 0, "more.png");
    expect_whole(by_table());
    expect_said("table.csv: 1 files are not among the images of");
    expect_said("first is line 1: 'nowhere.png'");
    expect_said("1 images are left out");
    expect_said("first is more.png");
    /* a table of another set refuses this one, unless it need not be of this one */
    write_text("table.csv", "nowhere.png,0,0,0,0\n");
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE, "none of its 1 files", NULL);
    enc_read_options of_some = *by_table();
    of_some.names_of_some = true;
    set_expect_refused(temporary_folder, &of_some, BTF_ERROR_BAD_FILE, "which are read by their names",
                       "none has a name with tl, pl, tv and pv", NULL);
    /* names with folders, and the folder of the set before them */
    write_table("table.csv", "", "tail/of/%s,%g,%g,%g,%g\n");
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE, "none of its 20 files",
                       "line 1: 'tail/of/000.png'", NULL);
    char format[PATH];
    snprintf(format, sizeof format, "%s/%%s,%%g,%%g,%%g,%%g\n", strrchr(temporary_folder, '/') + 1);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    write_table("table.csv", "", format);
#pragma GCC diagnostic pop
    expect_whole(by_table());
    /* a name that two images have, unless it is the whole path of one */
    assert_int_equal(mkdir(path_in("a"), 0777), 0);
    assert_int_equal(mkdir(path_in("b"), 0777), 0);
    write_image(0, 0, "a/x.png");
    write_image(0, 0, "b/x.png");
    write_text("table.csv", "x.png,0,0,0,0\n");
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE,
                       "line 1: 'x.png' is the name of several images", "a/x.png, b/x.png", NULL);
}

SET_TEST(test_bad_tables) {
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"", "names no file"},
        {"000.png,0,0,0\n", "line 1: 4 fields, expected file"},
        {"000.png,0,0,0,0,0\n", "line 1: 6 fields, expected file"},
        {"# x\n\n000.png,0,0,x,0\n", "line 3: theta_l: 'x' is not a number"},
        {"000.png,0,22,5,0,0\n", "line 1: 6 fields"},
        {"000.png,0,0.5rad,0,0\n", "line 1: phi_v: '0.5rad' is not a number"},
        {"000.png,0,nan,0,0\n", "line 1: phi_v: 'nan' is not a number"},
        {"000.png,90,0,0,0\n", "line 1: theta_v: 90 is not at least 0 and below 90"},
        {"000.png,0,0,-1,0\n", "line 1: theta_l: -1 is not at least 0"},
        {"000.png,0,0,0,0\n./000.png,0,0,0,0\n",
         "line 2: '000.png' is listed a second time (first in line 1)"},
        {"\"000.png,0,0,0,0\n", "line 1: a quote is not closed"},
        {"\"000\".png,0,0,0,0\n", "line 1: '.png,0,0,0,0' follows a quoted field"},
        {",0,0,0,0\n", "line 1: the file is empty"},
    };
    write_table("table.csv", "", "%s,%g,%g,%g,%g\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_text("table.csv", cases[i].text);
        set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE, "table.csv", cases[i].words,
                           NULL);
    }
    write_whole_file(path_in("table.csv"),
                     "\xff\xfe"
                     "0\0,\0",
                     6);
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_UNSUPPORTED, "table.csv: the text is UTF-16",
                       NULL);
    write_whole_file(path_in("table.csv"), "0\0,\0\n\0", 6);
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_UNSUPPORTED, "table.csv: the text is UTF-16",
                       NULL);
    write_whole_file(path_in("table.csv"), "000.png,0,0,0,0\0", 16);
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_BAD_FILE, "table.csv: not a text file",
                       NULL);
    unlink(path_in("table.csv"));
    set_expect_refused(temporary_folder, by_table(), BTF_ERROR_IO, "table.csv", NULL);
}

/* Entries of a folder that cannot be opened give a warning, and the rest is read. */
SET_TEST(test_folders) {
    write_set("tv%g_pv%g_tl%g_pl%g.png", 1);
    assert_int_equal(symlink("nowhere", path_in("dangling.png")), 0);
    assert_int_equal(symlink("loop", path_in("loop")), 0);
    assert_int_equal(mkdir(path_in("inner"), 0777), 0);
    assert_int_equal(symlink("..", path_in("inner/up")), 0);
    assert_int_equal(mkfifo(path_in("tv1_pv1_tl1_pl1.png"), 0666), 0);
    expect_whole(&plain);
    expect_said("dangling.png: No such file");
    expect_said("loop: Too many levels");
    expect_said("inner/up: is a folder that leads back to itself");
    expect_said("tv1_pv1_tl1_pl1.png: is neither a file nor a folder");
}

SET_TEST(test_unreadable_folder) {
    if (geteuid() == 0 && seteuid(65534) != 0) {
        print_message("skipped: root reads every folder, and cannot become another user here\n");
        return;
    }
    const uid_t user = geteuid();
    assert_true(seteuid(getuid()) == 0);
    write_set("tv%g_pv%g_tl%g_pl%g.png", 1);
    assert_int_equal(mkdir(path_in("lost+found"), 0), 0);
    assert_int_equal(chmod(temporary_folder, 0755), 0);
    assert_true(seteuid(user) == 0);
    if (access(temporary_folder, R_OK) == 0 &&
        faccessat(AT_FDCWD, temporary_folder, R_OK | X_OK, AT_EACCESS) != 0) {
        assert_true(seteuid(getuid()) == 0);
        print_message("skipped: %s is not to be reached by another user\n", temporary_folder);
        return;
    }
    all_messages[0] = '\0';
    enc_data *data = set_read_folder(&plain);
    assert_true(seteuid(getuid()) == 0);
    set_expect(data, 1e-7);
    enc_data_destroy(&data);
    expect_said("lost+found: Permission denied");
    assert_int_equal(chmod(path_in("lost+found"), 0755), 0);
    /* of the data set's own folder it is an error */
    set_expect_refused(path_in("nowhere"), &plain, BTF_ERROR_IO, "nowhere", NULL);
}

RUN_TESTS(NULL, NULL)
