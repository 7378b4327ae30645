#include "desk/webhooks/delivery_lane.h"

#include <algorithm>
#include <utility>

#include "desk/webhooks/retry_schedule.h"
#include "desk/webhooks/signature.h"

namespace tiltfeed::desk {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTablePause{10'000};  // the table is damaged, or its disk full
constexpr std::size_t kTelling = 8;          // characters of a secret

const char* remedy_of(int status) {
  if (status >= 300 && status < 400) return "redirects are not followed: state the URL that it leads to";
  if (status == 401 || status == 403) return "compare the secrets of both ends";
  if (status == 404 || status == 410) return "look at the URL";
  return "look into the receiver's log";
}

}  // namespace

DeliveryLane::DeliveryLane(config::Webhook hook, DeliveryStore& store, Log log)
    : hook_(std::move(hook)), store_(store), log_(std::move(log)) {}

bool DeliveryLane::look(Time now, std::int64_t wall) {
  if (sending_ || now < due_) return false;
  if (over_) let_go(now);
  if (!over_ && !head_ && stale_) load(now, wall);
  return head_ && !over_ && now >= due_;
}

void DeliveryLane::load(Time now, std::int64_t wall) {
  Result<std::optional<Delivery>> found = store_.first(hook_.url);
  if (!found) {
    due_ = now + kTablePause;
    return say(found.error().message);
  }
  head_ = std::move(*found);
  stale_ = false;
  if (!head_) return;
  const std::int64_t left = std::clamp<std::int64_t>(head_->due - wall, 0, kLongestWish.count() / 1000);
  due_ = now + std::chrono::seconds(left);
}

DeliveryLane::Request DeliveryLane::begin(std::int64_t wall) {
  sending_ = true;
  return {{"Content-Type: application/json", "User-Agent: tiltfeed",
           "Expect:", "X-Tiltfeed-Signature: " + signature_of(hook_.secret, wall, head_->body)},
          head_->body};
}

void DeliveryLane::end(const PostAnswer& answer, double chance, Time now, std::int64_t wall) {
  sending_ = false;
  const Verdict verdict = verdict_of(answer.status);
  if (verdict == Verdict::kAgain && wall - head_->queued < kGiveUpSeconds)
    return put_off(answer, chance, now, wall);
  if (verdict == Verdict::kTaken) {
    ++counts_.taken;
    if (head_->tries > 0) log_("took " + head_->id + " at try " + std::to_string(head_->tries + 1));
  } else if (verdict == Verdict::kRefused) {
    ++counts_.refused;
    log_(answered(answer) + " to " + head_->id + ", which is not sent again; " + remedy_of(answer.status));
  } else {
    ++counts_.in_vain, ++counts_.given_up;
    log_(answered(answer) + " to " + head_->id + " for " + std::to_string(kGiveUpSeconds / 3600) +
         " hours: it is given up");
  }
  said_.clear();
  let_go(now);
}

void DeliveryLane::put_off(const PostAnswer& answer, double chance, Time now, std::int64_t wall) {
  ++counts_.in_vain;
  ++head_->tries;
  const milliseconds pause = pause_after(head_->tries, chance, answer.retry_after);
  due_ = now + pause;
  head_->due = wall + std::chrono::ceil<std::chrono::seconds>(pause).count();
  say(answered(answer) + " to " + head_->id + "; it is tried again for " +
      std::to_string(kGiveUpSeconds / 3600) + " hours, what comes after it waits");
  if (const Result<void> kept = store_.put_off(head_->number, head_->tries, head_->due); !kept)
    say(kept.error().message);
}

/// A message that cannot be taken out of the table is not sent again all the same.
void DeliveryLane::let_go(Time now) {
  const Result<void> removed = store_.remove(head_->number);
  over_ = !removed;
  if (!removed) {
    due_ = now + kTablePause;
    return say(removed.error().message);
  }
  head_.reset();
  stale_ = true;
}

std::string DeliveryLane::answered(const PostAnswer& answer) const {
  if (answer.status == 0) return "does not answer (" + answer.why + ")";
  const bool tells = answer.said.find(hook_.secret.substr(0, kTelling)) != std::string::npos;
  const std::string said = tells ? "(text with the secret)" : answer.said;
  return "answers " + std::to_string(answer.status) + (said.empty() ? "" : " '" + said + "'");
}

/// Once, until something else is to be said.
void DeliveryLane::say(const std::string& text) {
  if (text != said_) log_(text);
  said_ = text;
}

milliseconds DeliveryLane::patience(Time now, milliseconds most) const {
  if (sending_ || (!head_ && !stale_ && !over_)) return most;
  return std::clamp(std::chrono::ceil<milliseconds>(due_ - now), milliseconds(0), most);
}

}  // namespace tiltfeed::desk
