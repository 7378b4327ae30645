#include "desk/webhooks/event_watch.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace tiltfeed::desk {
namespace {

constexpr std::uint64_t kNoJob = 1ULL << 52;  // `list` after it has the machine's name and no job

/// Without the key where the number is 0: from the beginning.
std::string asked_of(const char* op, const char* key, std::uint64_t number) {
  nlohmann::ordered_json json = {{"v", 1}, {"op", op}};
  if (number > 0) json[key] = number;
  return json.dump();
}

}  // namespace

EventWatch::EventWatch(std::string socket, KnownService known, EventCalls calls)
    : calls_(std::move(calls)), known_(std::move(known)), cursor_(known_.mark), link_(std::move(socket)) {}

void EventWatch::look(Time now, std::int64_t wall) {
  now_ = now, wall_ = wall;
  if (asking_ && !silent_ && now - asked_ >= kSilence) {
    silent_ = true;
    miss("no answer within " + std::to_string(kSilence.count() / 1000) + " s");
  }
  if (lost_ && known_.mark && !known_.lost_since && now >= lost_->due) tell_lost();
  if (!asking_ && now >= next_) ask();
}

std::chrono::milliseconds EventWatch::patience(Time now) const {
  Time due = now + kPeriod;
  if (!asking_) due = std::min(due, next_);
  if (asking_ && !silent_) due = std::min(due, asked_ + kSilence);
  if (lost_ && known_.mark && !known_.lost_since) due = std::min(due, lost_->due);
  return std::max(std::chrono::ceil<std::chrono::milliseconds>(due - now), std::chrono::milliseconds(0));
}

void EventWatch::ask() {
  asking_ = true, silent_ = false, asked_ = now_, next_ = now_ + kPeriod;
  link_.ask(
      machine_.empty() ? asked_of("list", "job", kNoJob) : asked_of("history", "from", cursor_.ask_from()),
      [this](const Result<std::string>& reply) { take(reply); });
}

void EventWatch::take(const Result<std::string>& reply) {
  asking_ = false;
  if (!reply && reply.error().code == Code::kIo) return miss(reply.error().message);
  find();
  if (!reply) return say("the service does not tell its runs: " + reply.error().message);
  if (machine_.empty()) return take_machine(*reply);
  const Result<HistoryPage> page = read_history(*reply);
  if (!page) return say(page.error().message);
  take_page(*page);
}

void EventWatch::take_machine(const std::string& reply) {
  const auto said = nlohmann::ordered_json::parse(reply, nullptr, false);
  const auto name = said.is_object() ? said.find("machine") : said.end();
  const bool named = said.is_object() && name != said.end() && name->is_string();
  machine_ = named ? name->get<std::string>() : "";
  if (machine_.empty()) return say("the service does not say which machine it has");
  next_ = now_;
}

void EventWatch::take_page(const HistoryPage& page) {
  const std::optional<RunCursor::News> news = cursor_.take(page);
  if (!news || news->more) next_ = now_;
  if (!news) return;
  if (news->anew)
    calls_.log("the service has another run history than before: what began since " +
               std::to_string(known_.mark ? known_.mark->began : 0) + " (seconds since 1970) is told");
  if (news->cut > 0)
    calls_.log(std::to_string(news->cut) + " runs that ended while the desk was down are not told: too many");
  KnownService fresh = known_;
  fresh.machine = machine_;
  fresh.mark = news->mark;
  std::vector<HookMessage> messages;
  for (const ToldRun& run : news->ended)
    if (std::optional<HookMessage> message = message_of(run, machine_, wall_))
      messages.push_back(std::move(*message));
  if (messages.empty() && fresh.machine == known_.machine && fresh.mark == known_.mark) return;
  if (!known_.mark) calls_.log("runs of " + machine_ + " that end from now on are told");
  if (!keep(fresh, messages)) cursor_ = RunCursor(known_.mark), next_ = now_ + kPeriod;
}

/// It may come again as another machine's.
void EventWatch::miss(const std::string& why) {
  machine_.clear();
  if (!lost_) lost_ = Lost{wall_, now_ + kLostAfter, why};
}

void EventWatch::find() {
  lost_.reset();
  if (!known_.lost_since) return;
  KnownService found = known_;
  found.lost_since.reset();
  keep(found, {});
}

void EventWatch::tell_lost() {
  KnownService lost = known_;
  lost.lost_since = lost_->since;
  if (!keep(lost, {lost_message(lost.machine, lost_->since, lost_->why, cursor_.on_machine())}))
    lost_->due = now_ + kPeriod;
}

bool EventWatch::keep(const KnownService& known, const std::vector<HookMessage>& messages) {
  if (!calls_.keep(known, messages)) return false;
  known_ = known;
  return true;
}

void EventWatch::say(const std::string& text) {
  if (text != said_) calls_.log(text);
  said_ = text;
}

}  // namespace tiltfeed::desk
