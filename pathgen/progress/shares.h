#pragma once
// How far plans are that several threads make at the same time.

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace tiltfeed::pathgen {

/// How far all directions are together, handed from the threads that cut them to the one that tells.
class Shares {
 public:
  explicit Shares(std::size_t directions) : done_(directions, 0.0) {}

  /// False: the user wants no more.
  bool tell(std::size_t direction, const std::string& stage, double fraction) {
    const std::lock_guard lock(mutex_);
    const double done = stage == "CL surface" ? kSurface * fraction
                        : stage == "passes"   ? kSurface + (kPasses - kSurface) * fraction
                        : stage.empty()       ? fraction
                                              : kPasses + (1.0 - kPasses) * fraction;
    sum_ += std::max(0.0, done - done_[direction]);
    done_[direction] = std::max(done_[direction], done);
    told_.push_back(std::min(1.0, sum_ / static_cast<double>(done_.size())));
    some_.notify_one();
    return !stopped_;
  }
  /// Ends it where it goes out of scope, after an exception, too.
  class End {
   public:
    explicit End(Shares& shares) : shares_(shares) {}
    ~End() {
      const std::lock_guard lock(shares_.mutex_);
      shares_.ended_ = true;
      shares_.some_.notify_one();
    }
    End(const End&) = delete;
    End& operator=(const End&) = delete;

   private:
    Shares& shares_;
  };
  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  /// Waits for it; nothing when all is done.
  std::optional<double> next() {
    std::unique_lock lock(mutex_);
    some_.wait(lock, [&] { return ended_ || !told_.empty(); });
    if (told_.empty()) return std::nullopt;
    const double share = told_.front();
    told_.pop_front();
    return share;
  }

 private:
  /// Of a direction, what is done after these stages.
  static constexpr double kSurface = 0.1, kPasses = 0.8;
  std::mutex mutex_;
  std::condition_variable some_;
  std::vector<double> done_;
  std::deque<double> told_;
  double sum_ = 0.0;
  bool ended_ = false, stopped_ = false;
};

}  // namespace tiltfeed::pathgen
