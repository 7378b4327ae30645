// Commands to the machine between jobs, the jog with its dead man's switch, and the seat.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "desk/api/replies.h"
#include "desk/api/run_api.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kFollow{100};  // between questions for a command's end
constexpr std::chrono::seconds kSeatLook{1};

std::string machine_request(const json& more) {
  json all = {{"v", 1}, {"op", "machine"}};
  all.update(more);
  return all.dump(-1, ' ', true, json::error_handler_t::replace);
}

std::uint64_t number_in(const std::string& reply) {
  const json said = json::parse(reply, nullptr, false);
  const auto found = said.find("order");
  return found != said.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

}  // namespace

// ---- commands --------------------------------------------------------------------------------------------

Reply RunApi::machine(const Request& request, std::uint64_t session) {
  const auto command = text_in(request.body, "command"), words = text_in(request.body, "words");
  if (!command) return refusal(400, "expected {\"command\": \"...\", \"words\": \"...\"}");
  return begin_order(request.ticket, session, *command, words.value_or(""));
}

Reply RunApi::jog(const Request& request, std::uint64_t session) {
  const auto words = text_in(request.body, "words");
  if (!words) return refusal(400, "expected {\"words\": \"X+ F500\"}");
  if (jog_.is_held()) return refusal(409, "a jog is in work");
  jog_.begin(session, Clock::now());
  const Reply reply = begin_order(request.ticket, session, "jog", *words);
  if (!reply.later) jog_.end();
  return reply;
}

Reply RunApi::jog_beat(const Request&, std::uint64_t session) {
  if (!jog_.beat(session, Clock::now())) return refusal(409, "no jog is held");
  if (order_ && order_->number != 0)
    link_.ask(machine_request({{"order", order_->number}, {"held", true}}),
              [](const Result<std::string>&) {});
  return text_reply("{}");
}

Reply RunApi::jog_stop(const Request&, std::uint64_t session) {
  jog_.let_go(session);
  look(Clock::now());
  return text_reply("{}");
}

Reply RunApi::begin_order(std::uint64_t ticket, std::uint64_t session, const std::string& command,
                          const std::string& words) {
  if (order_ && order_->ticket == 0) {  // our own question ends soon
    after_order_.emplace_back([this, ticket, session, command, words, held = jog_.is_held()] {
      if (held && !jog_.lives(Clock::now())) {
        jog_.end();
        return calls_.finish(ticket, refusal(409, "the key was let go before the jog began"));
      }
      const Reply reply = begin_order(ticket, session, command, words);
      if (!reply.later) calls_.finish(ticket, reply);
    });
    return later_reply();
  }
  if (order_) return refusal(409, "a command is in work on the machine; end it first");
  order_ = Order{0, ticket, false, {}};
  if (ticket != 0)
    watch_.note_order(json{{"command", command}, {"words", words}, {"by", calls_.name(session)}}.dump(
        -1, ' ', true, json::error_handler_t::replace));
  link_.ask(machine_request({{"command", command}, {"words", words}}),
            [this](const Result<std::string>& answer) {
              if (!answer || number_in(*answer) == 0)
                return end_order(answer);  // a run's own answer has no number
              if (!order_) return;
              order_->number = number_in(*answer);
              order_->next = Clock::now();
              if (!jog_.is_held()) return;
              link_.ask(machine_request({{"order", order_->number}, {"held", true}}),
                        [](const Result<std::string>&) {});
            });
  return later_reply();
}

void RunApi::end_order(const Result<std::string>& end) {
  if (!order_) return;
  const std::uint64_t ticket = order_->ticket;
  order_.reset();
  if (ticket != 0) jog_.end();
  if (ticket != 0) watch_.note_order("null");
  if (end) watch_.note_status(*end);
  if (ticket != 0) calls_.finish(ticket, reply_of(end));
  for (const auto& go : std::exchange(after_order_, {})) go();
  if (ticket != 0 && !order_ && watch_.job() == 0) ask_status();
}

/// Where the machine stands that no run is on.
void RunApi::ask_status() {
  if (!order_) (void)begin_order(0, 0, "status", "");
}

void RunApi::follow(Time now) {
  if (!order_ || order_->number == 0) return;
  if (jog_.is_due(now))
    link_.ask(machine_request({{"order", order_->number}, {"stop", true}}),
              [](const Result<std::string>&) {});
  if (order_->asking || now < order_->next) return;
  order_->asking = true;
  order_->next = now + kFollow;
  link_.ask(machine_request({{"order", order_->number}}), [this](const Result<std::string>& answer) {
    if (!order_) return;
    order_->asking = false;
    const json said = answer ? json::parse(*answer, nullptr, false) : json();
    if (!answer || !said.is_object() || !said.value("in_work", false)) end_order(answer);
  });
}

void RunApi::look(Time now) {
  watch_.look(now);
  follow(now);
  tell_seat();
}

int RunApi::patience_ms(Time now) const {
  int wait = watch_.patience_ms(now);
  const auto sooner = [&](Time due) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(due - now).count() + 1;
    const int ms = static_cast<int>(std::clamp<std::int64_t>(left, 0, 1000));
    wait = wait < 0 ? ms : std::min(wait, ms);
  };
  if (order_ && order_->number != 0 && !order_->asking) sooner(order_->next);
  if (order_ && order_->number != 0 && jog_.is_held()) sooner(jog_.due());
  if (seat_.owner() != 0) sooner(now + kSeatLook);
  return wait;
}

// ---- the seat --------------------------------------------------------------------------------------------

std::string RunApi::describe_seat() const {
  const Time now = Clock::now();
  json told = {{"owner", nullptr},
               {"asking", nullptr},
               {"lost", seat_.is_lost(now)},
               {"unanswered", seat_.is_unanswered(now)}};
  if (seat_.owner() != 0) told["owner"] = {{"session", seat_.owner()}, {"name", calls_.name(seat_.owner())}};
  if (seat_.asking() != 0)
    told["asking"] = {{"session", seat_.asking()}, {"name", calls_.name(seat_.asking())}};
  return told.dump(-1, ' ', true, json::error_handler_t::replace);
}

void RunApi::tell_seat() {
  std::string seat = describe_seat();
  if (seat == told_seat_) return;
  told_seat_ = std::move(seat);
  calls_.tell("seat", told_seat_);
}

Reply RunApi::seat(const Request&, std::uint64_t) {
  Reply reply;
  reply.body = describe_seat() + "\n";
  return reply;
}

Reply RunApi::ask_seat(const Request& request, std::uint64_t session) {
  seat_.ask(session, Clock::now());
  tell_seat();
  return seat(request, session);
}

Reply RunApi::give_seat(const Request& request, std::uint64_t session) {
  seat_.give(session, Clock::now());
  tell_seat();
  return seat(request, session);
}

Reply RunApi::keep_seat(const Request& request, std::uint64_t session) {
  seat_.keep(session);
  tell_seat();
  return seat(request, session);
}

Reply RunApi::beat_seat(const Request& request, std::uint64_t session) {
  seat_.beat(session, Clock::now());
  tell_seat();
  return seat(request, session);
}

void RunApi::sign_out(std::uint64_t session) {
  seat_.leave(session);
  tell_seat();
}

}  // namespace tiltfeed::desk
