#include "desk/api/shop_work.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "desk/api/replies.h"
#include "desk/work/progress_text.h"

namespace tiltfeed::desk {

using nlohmann::json;

namespace {

constexpr std::size_t kMostOrders = 16;

std::string json_text(const json& value) { return value.dump(-1, ' ', true, json::error_handler_t::replace); }

/// How an order ended.
Reply order_reply(const ChildEnd& end) {
  if (end.status != 0) return refusal(409, last_words(end.text, "tiltfeed: ", ""));
  const std::size_t begin = end.text.find('{');
  const json said = json::parse(begin == end.text.npos ? "" : end.text.substr(begin), nullptr, false);
  std::string text = "done";
  if (said.is_object() && said.contains("text") && said["text"].is_string()) text = said["text"];
  if (said.is_object() && said.contains("epoch") && said["epoch"].is_number())
    text = "the queue goes on, in epoch " + said["epoch"].dump();
  return text_reply(json_text({{"text", text}}));
}

}  // namespace

ShopWork::ShopWork(ShopOptions options, Teller tell, std::function<void(std::uint64_t, const Reply&)> finish)
    : options_(std::move(options)), tell_(std::move(tell)), finish_(std::move(finish)) {}

std::string ShopWork::describe() const {
  if (!is_shown()) return "null";
  return json_text({{"version", shown_}, {"state", state_}, {"error", error_}});
}

Reply ShopWork::view(Time now) const {
  if (!is_shown()) return refusal(409, "this desk shows no shop; start it with tiltfeed desk --shop");
  const double age = heard_ ? std::chrono::duration<double>(now - *heard_).count() : 0.0;
  std::string text = describe();
  text.pop_back();
  return text_reply(text + ", \"now\": " + std::to_string(now_) + ", \"age\": " + json(age).dump() +
                    ", \"shop\": " + seen_ + "}");
}

Reply ShopWork::order(std::uint64_t ticket, const std::string& command, std::uint64_t job) {
  if (!is_shown()) return refusal(409, "this desk shows no shop; start it with tiltfeed desk --shop");
  if (orders_.size() >= kMostOrders) return refusal(503, "many orders are in work; ask again");
  Order order{ticket, {options_.tiltfeed, "shop", command, "--json", "--shop", options_.url}};
  order.words.push_back(job > 0 ? std::to_string(job) : "--yes");
  orders_.push_back(std::move(order));
  next_order();
  Reply later;
  later.later = true;
  return later;
}

void ShopWork::next_order() {
  while (!acting_ && !orders_.empty()) {
    Result<ChildProcess> child = ChildProcess::start(orders_.front().words);
    if (child) return acting_.emplace(std::move(*child)), void();
    const std::uint64_t ticket = orders_.front().ticket;
    orders_.pop_front();
    finish_(ticket, refusal(507, child.error().message));
  }
}

std::string ShopWork::raise_text() const {
  const json seen = json::parse(seen_, nullptr, false);
  std::string text = "The queue is not halted.";
  if (seen.is_object() && !seen.value("halted", "").empty())
    text = "Halted: " + seen.value("halted", "") + ".";
  text +=
      " A job that the database has forgotten is offered again where the machine that took it has not been "
      "back.";
  std::string missing;
  if (seen.is_object())
    for (const json& machine : seen.value("machines", json::array()))
      if (!machine.value("back", true)) missing += (missing.empty() ? "" : ", ") + machine.value("name", "");
  text += missing.empty() ? " Every machine that is known has been back." : " Not back yet: " + missing + ".";
  return state_ == "up" ? text : text + " The database does not answer now: this is what it said last.";
}

std::vector<int> ShopWork::descriptors() const {
  std::vector<int> all;
  for (const auto* child : {&watch_, &acting_})
    if (*child) all.push_back((*child)->descriptor());
  return all;
}

void ShopWork::set(const std::string& state, const std::string& error) {
  if (state == state_ && error == error_) return;
  state_ = state, error_ = error;
  ++shown_;
  tell_("shop", describe());
}

void ShopWork::take_line(const std::string& line, Time now) {
  const json said = json::parse(line, nullptr, false);
  if (!said.is_object() || !said.contains("version")) {
    words_ = line + "\n";
    return;
  }
  said_ = now;
  const std::uint64_t version = said.value("version", std::uint64_t{0});
  now_ = said.value("now", std::int64_t{0});
  if (said.value("state", "") != "up") return set("lost", said.value("error", ""));
  heard_ = now;
  if (version != version_) {
    std::ostringstream text;
    text << std::ifstream(file(), std::ios::binary).rdbuf();
    version_ = version;
    if (json::accept(text.str())) seen_ = text.str();
    state_ = "up", error_.clear();
    ++shown_;
    return tell_("shop", describe());
  }
  set("up", "");
}

bool ShopWork::hear(int descriptor, Time now) {
  if (acting_ && acting_->descriptor() == descriptor) {
    if (!acting_->listen()) return true;
    const Reply reply = order_reply(acting_->end());
    acting_.reset();
    const std::uint64_t ticket = orders_.front().ticket;
    orders_.pop_front();
    finish_(ticket, reply);
    next_order();
    return true;
  }
  if (!watch_ || watch_->descriptor() != descriptor) return false;
  const bool over = watch_->listen();
  for (const std::string& line : watch_->take_lines()) take_line(line, now);
  if (!over) return true;
  const ChildEnd end = watch_->end();
  watch_.reset();
  due_ = now + kAgain;
  set("lost", last_words(words_ + end.text, "tiltfeed: ", options_.folder + "/"));
  return true;
}

void ShopWork::look(Time now) {
  if (!is_shown()) return;
  if (watch_ && said_ && now - *said_ > kSilent)
    set("lost", "the process that asks the database says nothing");
  if (watch_ || now < due_) return;
  due_ = now + kAgain;
  version_ = 0;
  words_.clear();
  Result<ChildProcess> child =
      ChildProcess::start({options_.tiltfeed, "shop", "watch", "--shop", options_.url, "--into", file()});
  if (!child) return set("lost", child.error().message);
  said_ = now;
  watch_.emplace(std::move(*child));
}

int ShopWork::patience_ms(Time now) const {
  if (!is_shown()) return -1;
  const Time due = watch_ ? said_.value_or(now) + kSilent + std::chrono::milliseconds(1) : due_;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - now).count();
  // One that was found silent is looked at now and then.
  return static_cast<int>(std::clamp<long>(left, watch_ ? 1000 : 0, 60000));
}

}  // namespace tiltfeed::desk
