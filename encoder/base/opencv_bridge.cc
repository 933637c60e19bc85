// The one door to OpenCV (C++): DIS optical flow.
//
// SPDX-License-Identifier: MIT
#include "opencv_bridge.h"

#include <cstring>
#include <mutex>
#include <new>

#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/video/tracking.hpp>

struct enc_cv_flow {
    cv::Ptr<cv::DISOpticalFlow> dis;
    cv::Mat result;
};

namespace {

int drop_message(int, const char *, const char *, const char *, int, void *) {
    return 0;
}

// Once a process, before anything else of OpenCV: no messages, no threads of its own, no OpenCL.
void prepare() {
    static std::once_flag once;
    std::call_once(once, [] {
        cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
        cv::redirectError(drop_message);
        cv::setNumThreads(1);
        cv::ocl::setUseOpenCL(false);
    });
}

// Runs `work`, which returns whether it succeeded; an exception is a failure.
template <typename Work>
bool guarded(Work work) noexcept {
    try {
        prepare();
        return work();
    } catch (...) {
        return false;
    }
}

} // namespace

enc_cv_flow *enc_cv_flow_create(void) {
    enc_cv_flow *flow = nullptr;
    const bool succeeded = guarded([&]() -> bool {
        flow = new enc_cv_flow;
        flow->dis = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM);
        return true;
    });
    if (!succeeded) {
        enc_cv_flow_destroy(&flow);
    }
    return flow;
}

void enc_cv_flow_destroy(enc_cv_flow **flow) {
    if (!flow || !*flow) {
        return;
    }
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
    const bool succeeded = guarded([&]() -> bool {
        const cv::Mat first(height, width, CV_8UC1, const_cast<unsigned char *>(from));
        const cv::Mat second(height, width, CV_8UC1, const_cast<unsigned char *>(to));
        flow->result.release(); // else DIS would start from the last pair's flow
        flow->dis->calc(first, second, flow->result);
        if (flow->result.rows != height || flow->result.cols != width || flow->result.type() != CV_32FC2)
            return false;
        const size_t row_bytes = static_cast<size_t>(width) * 2 * sizeof(float);
        for (int row = 0; row < height; row++)
            std::memcpy(out_xy + static_cast<size_t>(row) * static_cast<size_t>(width) * 2,
                        flow->result.ptr(row), row_bytes);
        return true;
    });
    return succeeded ? 0 : -1;
}
