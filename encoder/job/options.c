/* The command line of btf-encode. See options.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "options.h"

#include "encoder/input/options.h"

#include <string.h>

static struct {
    enc_options all;
    enc_option_values values;
    uint32_t effects; /* UINT32_MAX: auto */
    int method, preset, fit, relief, gloss, layout, centres;
    double hidden_threshold, error_threshold, btf_threshold;
    int window[2];
    double effect_tolerance[2]; /* dB; --method paper: dB for each MB */
    bool data_points;
    const char *metric; /* --metric, which was removed: it is refused, and the reason told */
} o = {.all = {.job = {.levels = 1}},
       .effects = UINT32_MAX,
       .preset = ENC_PRESET_MEDIUM,
       .hidden_threshold = 0.7};

/* Which of the options that belong to one method were given, in the order of the table. */
static bool given[18];

static const cli_option table[] = {
    {.short_name = 'o',
     .name = "output",
     .arg = "OUT",
     .type = CLI_STRING,
     .value = &o.all.job.output,
     .help = "material to write, NAME.btf.exr, or for a list the folder to write to;\n"
             "required"},
    {.name = "method",
     .type = CLI_CHOICE,
     .value = &o.method,
     .choices = "joint|paper",
     .help = "joint (default): low-bit factors, colour apart, best quality\n(format version 2);\npaper: "
             "stage after stage, as published (format version 1)"},
    {.name = "preset",
     .type = CLI_CHOICE,
     .value = &o.preset,
     .given = &given[0],
     .choices = "fast|medium|thorough|exhaustive",
     .only = "joint",
     .help = "joint: 0, 6, 12 and 24 sweeps of descent on the codes; default\nmedium; fast tries no "
             "effect, but a reflectance model alone (--effects)"},
    {.name = "effects",
     .type = CLI_EFFECTS,
     .value = &o.effects,
     .choices = "auto",
     .help = "auto (default): those that pay; joint takes a reflectance model\nalone, of 16 bytes a texel, where factors "
             "gain too little over it\nfor their bytes, paper the diffuse fit alone where that is better;\nor exactly these: "
             "joint has residual or shift,gain,residual,\npaper some of shadow,shift,hidden or none"},
    {.name = "effect-tolerance",
     .arg = "DB[,DB]",
     .type = CLI_CUSTOM,
     .value = o.effect_tolerance,
     .parse = enc_parse_tolerance,
     .help = "joint: bytes are used as long as a tenth more of them gains this\n"
             "many dB at samples left out of the fit; 0: all of --budget. paper:\n"
             "--effects auto leaves out an effect that gains less than this many\n"
             "dB, linear, and this many for each MB that it adds. Default 0.05,0"},
    {.name = "budget",
     .type = CLI_BYTES,
     .value = &o.all.job.joint.budget,
     .given = &given[1],
     .minimum = 1,
     .maximum = 0x1p62,
     .only = "joint",
     .help =
         "joint: bytes on the GPU at most (it may need fewer,\n--effect-tolerance); default what the "
         "paper's layout takes\n(2.36 MB for 64x64 and 81 directions), but at most 62.5 kB times\nthe root "
         "of the number of texels (8 MB for 128x128, 16 MB for\n256x256, 25 MB for 400x400)"},
    {.name = "quality",
     .arg = "DB",
     .type = CLI_DOUBLE,
     .value = &o.all.job.joint.quality,
     .given = &given[2],
     .minimum = 0,
     .maximum = 100,
     .only = "joint",
     .help = "joint: the fewest bytes that reach this PSNR (sRGB-coded), at\nmost --budget"},
    {.name = "metric", .type = CLI_STRING, .value = &o.metric},
    {.name = "fit",
     .type = CLI_CHOICE,
     .value = &o.fit,
     .given = &given[15],
     .choices = "between|samples",
     .help = "between: the values stored at views and lights are fitted so that\n"
             "blends of three of them come close to a smooth interpolation, as far\n"
             "as that gains between the samples and adds little to the codec's\n"
             "error at them; samples: the samples as they are. Default between; with\n"
             "--method paper samples"},
    {.name = "relief",
     .type = CLI_CHOICE,
     .value = &o.relief,
     .given = &given[16],
     .choices = "auto|off",
     .only = "joint",
     .help = "joint: heights, found from the images, by which the texels of\n"
             "neighbouring views are shifted before they are blended; auto keeps\n"
             "them where predictions of views left out get better by them.\n"
             "Default auto; with --preset fast off"},
    {.name = "gloss",
     .type = CLI_CHOICE,
     .value = &o.gloss,
     .given = &given[17],
     .choices = "auto|off|0|1|2",
     .only = "joint",
     .help = "joint: how far the lights of neighbouring views move towards the\n"
             "same half vector before they are blended, in quarters, so that\n"
             "highlights stay sharp; off is 0. Default auto; with --preset fast\n"
             "off"},
    {.name = "layout",
     .type = CLI_CHOICE,
     .value = &o.layout,
     .given = &given[3],
     .choices = "paper|tight",
     .only = "paper",
     .help = "paper: one atlas, as in section 3.1 of the paper (paper, the default\n"
             "without --levels), or one texture for each effect (tight)"},
    {.name = "levels",
     .arg = "N|all",
     .type = CLI_CUSTOM,
     .value = &o.all.job.levels,
     .parse = enc_parse_levels,
     .help = "levels of detail, each of half the size; all: down to one texel;\n"
             "default 1. Those beyond the first take about a third more bytes\n"
             "of texels, and as much more time"},
    {.name = "half",
     .type = CLI_FLAG,
     .value = &o.all.job.half_float,
     .given = &given[14],
     .only = "paper",
     .help = "paper: SBRDF parameters as half floats"},
    ENC_INPUT_OPTIONS(o.all.job.read),
    {.name = "lobes",
     .type = CLI_INT,
     .value = &o.all.job.paper.fit.lobes,
     .given = &given[4],
     .minimum = 1,
     .maximum = 4,
     .only = "paper",
     .help = "paper: Lafortune lobes; default 3"},
    {.name = "rounds",
     .type = CLI_INT,
     .value = &o.all.job.paper.fit.rounds,
     .given = &given[5],
     .minimum = 0,
     .maximum = 16,
     .only = "paper",
     .help = "paper: shadow rejections of the fit; default 3"},
    {.name = "starts",
     .type = CLI_INT,
     .value = &o.all.job.paper.fit.starts,
     .given = &given[6],
     .minimum = 1,
     .maximum = ENC_FIT_MAX_STARTS,
     .only = "paper",
     .help = "paper: starts of a texel's first fit; default 4"},
    {.name = "error-threshold",
     .type = CLI_DOUBLE,
     .value = &o.error_threshold,
     .given = &given[7],
     .minimum = 0,
     .maximum = 1e6,
     .only = "paper",
     .help = "paper: relative error that means shadow; default 0.3"},
    {.name = "btf-threshold",
     .type = CLI_DOUBLE,
     .value = &o.btf_threshold,
     .given = &given[8],
     .minimum = 0,
     .maximum = 1e6,
     .only = "paper",
     .help = "paper: luminance below which shadow is possible; default 0.3"},
    {.name = "flow-lights",
     .type = CLI_INT,
     .value = &o.all.job.paper.flow.lights,
     .given = &given[9],
     .minimum = 1,
     .maximum = 256,
     .only = "paper",
     .help = "paper: lights that vote on shifts; default all"},
    {.name = "hidden-threshold",
     .type = CLI_DOUBLE,
     .value = &o.hidden_threshold,
     .given = &given[10],
     .minimum = 0.001,
     .maximum = 1,
     .only = "paper",
     .help = "paper: HiddenRatio above which a point is hidden; default 0.7"},
    {.name = "window",
     .type = CLI_SIZE,
     .value = o.window,
     .given = &given[11],
     .minimum = 1,
     .maximum = 16384,
     .only = "paper",
     .help = "paper: search window of the refinement; default 256x256, and\n64x64 around the voted shift "
             "beyond 64x64 texels"},
    {.name = "centres",
     .type = CLI_INT,
     .value = &o.centres,
     .given = &given[12],
     .minimum = 1,
     .maximum = BTF_MAX_CENTRES,
     .only = "paper",
     .help = "paper: cluster centres; default what the atlas leaves room for"},
    {.name = "data-points",
     .type = CLI_FLAG,
     .value = &o.data_points,
     .given = &given[13],
     .only = "paper",
     .help = "paper: centres are data points nearest to the centroids"},
    {.name = "report",
     .arg = "FILE",
     .type = CLI_STRING,
     .value = &o.all.job.report,
     .help = "write the report as JSON"},
    {.name = "pictures",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &o.all.job.pictures,
     .help = "write pictures of the stages and a montage"},
    {.name = "checkpoint",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &o.all.job.checkpoint,
     .help = "keep what stages find in DIR until the material is written, so\nthat --resume can go on "
             "after a stop"},
    {.name = "resume",
     .type = CLI_FLAG,
     .value = &o.all.job.resume,
     .help = "go on from --checkpoint; the same bytes come out"},
    {.name = "item",
     .type = CLI_INT,
     .value = &o.all.item,
     .minimum = 1,
     .maximum = 1e9,
     .help = "only this input of a list, counted from 1 (for job arrays)"},
    {.name = "predict",
     .arg = "FROM",
     .type = CLI_STRING,
     .value = &o.all.predict,
     .help = "encode nothing: print the time of each stage, the memory and the\n"
             "scratch files that it would take. FROM: self (this machine is\n"
             "measured), or the --report of an encode with the same options, of\n"
             "smaller data for instance"},
    {.name = "threads",
     .type = CLI_INT,
     .value = &o.all.threads,
     .minimum = 1,
     .maximum = 1024,
     .help = "default: all cores; of a rank those it may use, divided by the\nranks that share them. The "
             "output does not depend on it"},
    {.name = "memory",
     .type = CLI_BYTES,
     .value = &o.all.memory,
     .minimum = 1,
     .maximum = 0x1p62,
     .help = "memory that a process may use at most; default half of the machine's,\n"
             "divided by its ranks. Data beyond half of it go through a scratch\n"
             "file in $TMPDIR, and then shift, gain and relief are not tried, nor\n"
             "without room for their tables. Less than the data need is refused"},
    {.short_name = 'q',
     .name = "quiet",
     .type = CLI_FLAG,
     .value = &o.all.job.quiet,
     .help = "no progress, no tables, no information; warnings stay"},
    {.type = CLI_END},
};

const cli_program enc_program = {
    .name = "btf-encode",
    .usage = "INPUT -o OUT.btf.exr [OPTION...]",
    .summary =
        "Compresses a bidirectional texture function into a material of a few GPU textures.\n"
        "INPUT is a folder or an archive (zip) of images whose names hold tl, pl, tv and pv, each\n"
        "followed by an angle in degrees (UBO2003, ATRIUM, UTIA, Bonn spectral), or a .btf file of\n"
        "Bonn (UBO2014: DFMF, FMF, PVF, BDI), or a list of inputs: a text file NAME.txt with one a line\n"
        "(# begins a comment). For a list, OUT, the report and the pictures are folders.",
    .details =
        "The tables printed at the end, and the report, measure what the written material decodes to.\n"
        "A list goes on after an input that fails. At its end come a line for each input, and the exit\n"
        "code of the first failure.\n"
        "mpirun -n N btf-encode ... splits one encode over N processes, of one machine or of several, "
        "which write\n"
        "the same bytes as one. Each reads its share of the images and leaves it in a scratch file: TMPDIR "
        "names\n"
        "a folder that all machines share. MPI is not touched where no launcher started the program.",
    .example = "btf-encode UBO_IMPALLA256.zip --size 64x64 -o impalla.btf.exr --pictures pictures",
    .options = table,
    .min_arguments = 1,
    .max_arguments = 1,
};

static btf_result refuse_other(const char *method) {
    for (const cli_option *option = table; option->type != CLI_END; option++) {
        if (option->only && strcmp(option->only, method) != 0 && *option->given) {
            return cli_error(&enc_program, BTF_ERROR_USAGE, "option --%s: for --method %s only, not for %s",
                             option->name, option->only, method);
        }
    }
    return BTF_OK;
}

/* The effects that --method paper may use, any of them or none. */
static const uint32_t paper_effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN;

/* The effects of factors with match (factor/match/match.h). */
static const uint32_t matched_effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL;

/* Checks effects and the unit of their tolerance, by method. */
static btf_result check_effects(const enc_job *job) {
    const bool named = o.effects != UINT32_MAX, joint = job->method == ENC_METHOD_JOINT;
    const char *refused = NULL;
    if (joint && named && o.effects != BTF_EFFECT_RESIDUAL && o.effects != matched_effects) {
        refused = "option --effects: --method joint has residual alone, or shift,gain,residual; shadow and "
                  "hidden are effects of --method paper";
    } else if (joint && o.effect_tolerance[1] > 0) {
        refused =
            "option --effect-tolerance: --method joint takes one number, of dB for a tenth more bytes";
    } else if (!joint && named && (o.effects & ~paper_effects)) {
        refused = "option --effects: --method paper has shadow, shift and hidden only";
    }
    return refused ? cli_error(&enc_program, BTF_ERROR_USAGE, "%s", refused) : BTF_OK;
}

static void settle_paper(enc_job *job) {
    job->fit = given[15] ? (enc_fit_goal)o.fit : ENC_FIT_SAMPLES;
    job->layout = given[3]           ? (o.layout == 1 ? BTF_LAYOUT_TIGHT : BTF_LAYOUT_PAPER)
                  : job->levels == 1 ? BTF_LAYOUT_PAPER
                                     : BTF_LAYOUT_TIGHT;
    job->paper.effects = o.effects == UINT32_MAX ? paper_effects : o.effects;
    job->paper.choose = job->paper.fallback = o.effects == UINT32_MAX;
    job->paper.effect_tolerance = o.effect_tolerance[0];
    job->paper.effect_tolerance_bytes = o.effect_tolerance[1];
    job->paper.fit.t_error = (float)o.error_threshold;
    job->paper.fit.t_btf = (float)o.btf_threshold;
    job->paper.flow.hidden_threshold = (float)o.hidden_threshold;
    job->paper.refine.columns = o.window[0];
    job->paper.refine.rows = o.window[1];
    job->paper.cluster.data_points = o.data_points;
    job->paper.centres = (uint32_t)o.centres;
}

static void settle_joint(enc_job *job) {
    static const int gloss[] = {-1, 0, 0, 1, 2}; /* as --gloss lists them */
    job->fit = (enc_fit_goal)o.fit;
    job->layout = BTF_LAYOUT_TIGHT;
    job->joint.preset = (enc_preset)o.preset;
    job->joint.choose = o.effects == UINT32_MAX;
    job->joint.effects = o.effects == UINT32_MAX ? BTF_EFFECT_RESIDUAL : o.effects;
    job->joint.tolerance = o.effect_tolerance[0];
    const bool fast = job->joint.preset == ENC_PRESET_FAST;
    job->relief.relief = given[16] ? o.relief == 0 : !fast;
    job->relief.gloss = given[17] ? gloss[o.gloss] : fast ? 0 : -1;
}

/* Checks what depends on several options, and fills in the job. */
static btf_result settle(void) {
    enc_job *job = &o.all.job;
    if (!job->output && !o.all.predict) {
        return cli_error(&enc_program, BTF_ERROR_USAGE,
                         "option --output is missing: expected -o OUT.btf.exr");
    }
    if (job->resume && !job->checkpoint) {
        return cli_error(&enc_program, BTF_ERROR_USAGE,
                         "option --resume: expected --checkpoint DIR as well");
    }
    if (o.metric) {
        return cli_error(
            &enc_program, BTF_ERROR_USAGE,
            "option --metric: it was removed; --method joint fits the square root of radiance, as "
            "balanced and srgb did, and --method paper radiance; leave it out");
    }
    job->method = (enc_method)o.method;
    btf_result refused = refuse_other(enc_method_name(job->method));
    if (refused == BTF_OK) {
        refused = check_effects(job);
    }
    if (refused != BTF_OK) {
        return refused;
    }
    if (job->method == ENC_METHOD_PAPER) {
        settle_paper(job);
    } else {
        settle_joint(job);
    }
    if (job->levels != 1 && job->layout == BTF_LAYOUT_PAPER) {
        return cli_error(&enc_program, BTF_ERROR_USAGE,
                         "option --levels: --layout paper has one level; take --layout tight");
    }
    enc_settings_describe(job, &o.values);
    job->option_values = o.values.list;
    return BTF_OK;
}

bool enc_options_parse(int argc, char **argv, int threads, uint64_t memory, const enc_options **out_options,
                       int *out_exit_code) {
    enc_job *job = &o.all.job;
    cli_arguments arguments;
    job->paper = enc_paper_options_default();
    job->joint = enc_joint_options_default();
    o.error_threshold = job->paper.fit.t_error;
    o.btf_threshold = job->paper.fit.t_btf;
    o.effect_tolerance[0] = job->joint.tolerance;
    o.all.threads = threads;
    o.all.memory = memory;
    *out_options = &o.all;
    if (!cli_parse(&enc_program, argc, argv, &arguments, out_exit_code)) {
        return false;
    }
    job->input = arguments.values[0];
    const btf_result result = settle();
    *out_exit_code = btf_result_exit_code(result);
    return result == BTF_OK;
}
