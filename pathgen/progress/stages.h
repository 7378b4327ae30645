#pragma once
// Planning stages: progress, timing and cancellation.

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::pathgen {

/// Called on one thread with the stage's name and 0..1; return false to cancel.
using Progress = std::function<bool(const char* stage, double fraction)>;

struct StageTime {
  std::string stage;
  double seconds = 0.0;
};

/// What a stage returns that was told to stop.
inline tl::unexpected<Error> cancelled() {
  return fail(Code::kCancelled, "planning was cancelled; nothing was written");
}

class Stages {
 public:
  /// Both must outlive it.
  Stages(const Progress& progress, std::vector<StageTime>& times) : progress_(progress), times_(times) {}

  /// Starts a stage, ending the one before; false if the user cancels.
  bool begin(const char* stage) {
    end();
    stage_ = stage, start_ = std::chrono::steady_clock::now();
    return report(0.0);
  }
  /// `fraction` of the stage is done; false if the user cancels, or has before.
  bool report(double fraction) {
    if (!stopped_ && progress_ && !progress_(stage_, fraction)) stopped_ = true;
    return !stopped_;
  }
  bool stopped() const { return stopped_; }
  void end() {
    if (stage_ == nullptr) return;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start_;
    times_.push_back({stage_, taken.count()});
    stage_ = nullptr;
  }

 private:
  const Progress& progress_;
  std::vector<StageTime>& times_;
  const char* stage_ = nullptr;
  std::chrono::steady_clock::time_point start_;
  bool stopped_ = false;
};

}  // namespace tiltfeed::pathgen
