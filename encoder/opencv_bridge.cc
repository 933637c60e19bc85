// The one door to OpenCV (C++): image decoding and encoding, text drawing, DIS optical flow.
//
// SPDX-License-Identifier: MIT
#include "opencv_bridge.h"

#include <climits>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

struct enc_cv_flow {
    cv::Ptr<cv::DISOpticalFlow> dis;
    cv::Mat result;
};

namespace {

int drop_message(int, const char *, const char *, const char *, int, void *) {
    return 0;
}

// Once a process, before anything else of OpenCV: no messages, no threads of its own, no OpenCL, and no
// pixel limit below what encoder/image.c has already accepted.
void prepare() {
    static std::once_flag once;
    std::call_once(once, [] {
        cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
        cv::redirectError(drop_message);
        cv::setNumThreads(1);
        cv::ocl::setUseOpenCL(false);
    });
}

// Runs `work`, turning every exception into a result code.
template <typename Work>
btf_result guarded(Work work, btf_result failure) noexcept {
    try {
        prepare();
        return work();
    } catch (const std::bad_alloc &) {
        return BTF_ERROR_MEMORY;
    } catch (const cv::Exception &error) {
        return error.code == cv::Error::StsNoMem ? BTF_ERROR_MEMORY : failure;
    } catch (...) {
        return failure;
    }
}

btf_result copy_out(const std::vector<unsigned char> &bytes, unsigned char **out_data, size_t *out_size) {
    unsigned char *copy = static_cast<unsigned char *>(std::malloc(bytes.size()));
    if (!copy)
        return BTF_ERROR_MEMORY;
    std::memcpy(copy, bytes.data(), bytes.size());
    *out_data = copy;
    *out_size = bytes.size();
    return BTF_OK;
}

// Hershey's capitals are 21 units high at scale 1.
constexpr double capital_height = 21.0;

int text_thickness(double size) {
    return size >= 24.0 ? 2 : 1;
}

} // namespace

btf_result enc_cv_decode_image(const void *data, size_t size, enc_cv_image *out_image) {
    return guarded(
        [&]() -> btf_result {
            if (size > static_cast<size_t>(INT_MAX))
                return BTF_ERROR_UNSUPPORTED;
            const cv::Mat bytes(1, static_cast<int>(size), CV_8UC1, const_cast<void *>(data));
            cv::Mat image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED); // implies IGNORE_ORIENTATION
            if (image.empty())
                return BTF_ERROR_BAD_FILE;
            if (image.channels() == 3)
                cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
            else if (image.channels() == 4)
                cv::cvtColor(image, image, cv::COLOR_BGRA2RGB);
            else if (image.channels() != 1)
                return BTF_ERROR_UNSUPPORTED;
            int depth;
            switch (image.depth()) {
            case CV_8U:
                depth = 8;
                break;
            case CV_16U:
                depth = 16;
                break;
            case CV_32F:
                depth = 32;
                break;
            default:
                return BTF_ERROR_UNSUPPORTED;
            }
            const size_t row_bytes = static_cast<size_t>(image.cols) * image.elemSize();
            char *pixels = static_cast<char *>(std::malloc(row_bytes * static_cast<size_t>(image.rows)));
            if (!pixels)
                return BTF_ERROR_MEMORY;
            for (int row = 0; row < image.rows; row++)
                std::memcpy(pixels + static_cast<size_t>(row) * row_bytes, image.ptr(row), row_bytes);
            *out_image = enc_cv_image{image.cols, image.rows, image.channels(), depth, pixels};
            return BTF_OK;
        },
        BTF_ERROR_BAD_FILE);
}

btf_result enc_cv_encode_jpeg(int width, int height, const unsigned char *rgb, int quality,
                              unsigned char **out_data, size_t *out_size) {
    return guarded(
        [&]() -> btf_result {
            cv::Mat bgr;
            cv::cvtColor(cv::Mat(height, width, CV_8UC3, const_cast<unsigned char *>(rgb)), bgr,
                         cv::COLOR_RGB2BGR);
            // Naming both qualities is OpenCV 4.6's only way to turn chroma subsampling off.
            const std::vector<int> options = {cv::IMWRITE_JPEG_QUALITY,        quality,
                                              cv::IMWRITE_JPEG_LUMA_QUALITY,   quality,
                                              cv::IMWRITE_JPEG_CHROMA_QUALITY, quality};
            std::vector<unsigned char> bytes;
            if (!cv::imencode(".jpg", bgr, bytes, options))
                return BTF_ERROR_INTERNAL;
            return copy_out(bytes, out_data, out_size);
        },
        BTF_ERROR_INTERNAL);
}

btf_result enc_cv_encode_png(int width, int height, int channels, int depth, const void *pixels,
                             unsigned char **out_data, size_t *out_size) {
    return guarded(
        [&]() -> btf_result {
            const cv::Mat image(height, width, CV_MAKETYPE(depth == 16 ? CV_16U : CV_8U, channels),
                                const_cast<void *>(pixels));
            cv::Mat bgr = image;
            if (channels == 3)
                cv::cvtColor(image, bgr, cv::COLOR_RGB2BGR);
            std::vector<unsigned char> bytes;
            if (!cv::imencode(".png", bgr, bytes))
                return BTF_ERROR_INTERNAL;
            return copy_out(bytes, out_data, out_size);
        },
        BTF_ERROR_INTERNAL);
}

void enc_cv_draw_text(unsigned char *rgb, int width, int height, int x, int y, const char *text,
                      double size, const unsigned char colour[3]) {
    guarded(
        [&]() -> btf_result {
            cv::Mat image(height, width, CV_8UC3, rgb);
            cv::putText(image, text, cv::Point(x, y), cv::FONT_HERSHEY_SIMPLEX, size / capital_height,
                        cv::Scalar(colour[0], colour[1], colour[2]), text_thickness(size), cv::LINE_AA);
            return BTF_OK;
        },
        BTF_ERROR_INTERNAL);
}

int enc_cv_text_width(const char *text, double size) {
    int width = 0;
    guarded(
        [&]() -> btf_result {
            width = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size / capital_height,
                                    text_thickness(size), nullptr)
                        .width;
            return BTF_OK;
        },
        BTF_ERROR_INTERNAL);
    return width;
}

enc_cv_flow *enc_cv_flow_create(void) {
    enc_cv_flow *flow = nullptr;
    const btf_result result = guarded(
        [&]() -> btf_result {
            flow = new enc_cv_flow;
            flow->dis = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM);
            return BTF_OK;
        },
        BTF_ERROR_INTERNAL);
    if (result != BTF_OK)
        enc_cv_flow_destroy(&flow);
    return flow;
}

void enc_cv_flow_destroy(enc_cv_flow **flow) {
    if (!flow || !*flow)
        return;
    delete *flow;
    *flow = nullptr;
}

void enc_cv_flow_tune(enc_cv_flow *flow, int finest_level, int patch_stride, int descent_steps,
                      int smoothing_rounds) {
    flow->dis->setFinestScale(finest_level);
    flow->dis->setPatchStride(patch_stride);
    flow->dis->setGradientDescentIterations(descent_steps);
    flow->dis->setVariationalRefinementIterations(smoothing_rounds);
}

int enc_cv_flow_compute(enc_cv_flow *flow, int width, int height, const unsigned char *from,
                        const unsigned char *to, float *out_xy) {
    const btf_result result = guarded(
        [&]() -> btf_result {
            const cv::Mat first(height, width, CV_8UC1, const_cast<unsigned char *>(from));
            const cv::Mat second(height, width, CV_8UC1, const_cast<unsigned char *>(to));
            flow->result.release(); // else DIS would start from the last pair's flow
            flow->dis->calc(first, second, flow->result);
            if (flow->result.rows != height || flow->result.cols != width ||
                flow->result.type() != CV_32FC2)
                return BTF_ERROR_INTERNAL;
            const size_t row_bytes = static_cast<size_t>(width) * 2 * sizeof(float);
            for (int row = 0; row < height; row++)
                std::memcpy(out_xy + static_cast<size_t>(row) * static_cast<size_t>(width) * 2,
                            flow->result.ptr(row), row_bytes);
            return BTF_OK;
        },
        BTF_ERROR_INTERNAL);
    return result == BTF_OK ? 0 : -1;
}

int enc_cv_flow_dis(int width, int height, const unsigned char *from, const unsigned char *to,
                    float *out_xy) {
    enc_cv_flow *flow = enc_cv_flow_create();
    if (!flow)
        return -1;
    const int result = enc_cv_flow_compute(flow, width, height, from, to, out_xy);
    enc_cv_flow_destroy(&flow);
    return result;
}
