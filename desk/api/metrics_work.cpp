#include "desk/api/metrics_work.h"

#include <utility>

#include "desk/work/progress_text.h"

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kMostWaiting = 16;
constexpr const char* kFormat = "text/plain; version=0.0.4; charset=utf-8";

}  // namespace

MetricsWork::MetricsWork(MetricsOptions options, std::function<void(std::uint64_t, const Reply&)> finish)
    : options_(std::move(options)), finish_(std::move(finish)) {}

Reply MetricsWork::ask(std::uint64_t ticket) {
  if (options_.config.empty())
    return refusal(409, "this desk knows no service's file; start it with tiltfeed desk --beside FILE");
  if (waiting_.size() >= kMostWaiting) return refusal(503, "many ask for these figures; ask again");
  waiting_.push_back(ticket);
  if (!child_) begin();
  Reply later;
  later.later = true;
  return later;
}

void MetricsWork::begin() {
  asked_ = std::exchange(waiting_, {});
  if (asked_.empty()) return;
  Result<ChildProcess> child =
      ChildProcess::start({options_.tiltfeed, "metrics", "--config", options_.config});
  if (child) return child_.emplace(std::move(*child)), void();
  for (const std::uint64_t ticket : std::exchange(asked_, {}))
    finish_(ticket, refusal(503, child.error().message));
}

void MetricsWork::hear() {
  if (!child_ || !child_->listen()) return;
  const ChildEnd end = child_->end();
  child_.reset();
  Reply reply;
  reply.type = kFormat;
  reply.body = end.text;
  if (end.status != 0) reply = refusal(503, last_words(end.text, "tiltfeed: ", ""));
  for (const std::uint64_t ticket : std::exchange(asked_, {})) finish_(ticket, reply);
  begin();
}

}  // namespace tiltfeed::desk
