// What an operator asks of the machine between jobs, and the little that is possible while one is on it.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/machine/advice.h"
#include "daemon/machine/order_mark.h"
#include "daemon/protocol/grbl_words.h"
#include "daemon/service/job_service.h"
#include "daemon/service/run_place.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

std::string order_reply(ordered_json json) {
  json["v"] = kApiVersion;
  json["ok"] = true;
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace) + "\n";
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// In a run: the run's own orders. Errors: kUsage.
Result<OperatorCommand> override_of(const std::vector<std::string>& words) {
  int percent = 0;
  const bool number =
      words.size() == 2 && std::from_chars(words[1].data(), words[1].data() + words[1].size(), percent).ptr ==
                               words[1].data() + words[1].size();
  const bool rapid = number && words[0] == "rapid";
  if (number &&
      (rapid ? percent == 25 || percent == 50 || percent == 100 : percent >= 10 && percent <= 200)) {
    if (words[0] == "feed") return OperatorCommand{Order::kFeedOverride, percent};
    if (rapid) return OperatorCommand{Order::kRapidOverride, percent};
    if (words[0] == "spindle") return OperatorCommand{Order::kSpindleOverride, percent};
  }
  return fail(Code::kUsage, "override: feed or spindle with 10 to 200 percent, rapid with 25, 50 or 100");
}

ordered_json status_of(const RunView& view) {
  const SendState& state = view.state;
  ordered_json json = {
      {"job", view.job},        {"phase", phase_name(state.phase)},
      {"state", state.machine}, {"executed", state.executed},
      {"blocks", state.total},  {"silent_seconds", std::round(view.silent_seconds * 10.0) / 10.0}};
  if (!state.held.empty()) json["held"] = state.held;
  json.update(ordered_json::parse(run_place_json(state)));
  std::string text =
      "state    " +
      (state.machine.empty() ? "the controller has not said" : grbl_state_text(state.machine, 0)) +
      "\njob      " + std::to_string(view.job) + ", " + phase_name(state.phase) + ", " +
      std::to_string(state.executed) + " of " + std::to_string(state.total) + " blocks";
  if (!state.held.empty()) text += "\nheld     " + state.held;
  if (const double silent = view.silent_seconds; silent > kToldSilent)
    text += "\nsilent   the controller was last heard " + decimal(silent, 0) + " s ago";
  if (const std::string place = describe(state.place); !place.empty()) text += "\nprogram  " + place;
  std::string overrides;
  const auto tell = [&](const char* name, int percent) {
    if (percent == 0) return;
    overrides += std::string(overrides.empty() ? "" : ", ") + name + " " + std::to_string(percent) + " %";
  };
  tell("feed", state.feed_override);
  tell("rapid", state.rapid_override);
  tell("spindle", state.spindle_override);
  if (!overrides.empty()) text += "\noverride " + overrides;
  return {{"text", text}, {"result", json}};
}

}  // namespace

/// A new command, or a word to the newest: how it ended, that the key is still held, that it is to end.
Result<std::string> JobService::machine(const ApiRequest& request) {
  if (request.order != 0) return follow_order(request);
  const MachineOrder* const order = find_machine_order(request.command);
  if (order == nullptr)
    return fail(Code::kUsage,
                "'" + request.command + "' is no command for a machine; see tiltfeed machine --help");
  const std::vector<std::string> words = split(request.words);
  if (runner_->busy()) return while_running(*order, words);
  if (reset_.valid()) return fail(Code::kUsage, "the machine is being reset");
  if (leaving_) return fail(Code::kUsage, "the service is ending");
  if (const std::uint64_t next = errands_.machine(); next != 0)
    return fail(Code::kUsage, "the machine is about to be given to job " + std::to_string(next));
  if (worker_->busy())
    return fail(Code::kUsage, worker_->name() + " is in work on the machine; `tiltfeed stop` ends it");
  // What an operator moves or changes must not be surprised by a job that starts by itself.
  if (!order->while_running) queue_moves_ = false;
  note_moved(*order, words);
  std::function<void()> ended;
  if (!order->while_running) {
    if (const Result<void> marked =
            mark_order(config_.spool, link_.kind, request.command + " " + request.words);
        !marked)
      log(Severity::kWarning, 0,
          marked.error().message + "; should this service die, safe-stop does not know of " +
              std::string(order->name));
    ended = [folder = config_.spool] { clear_order_mark(folder); };
  }
  return order_reply({{"order", worker_->start(config_.machine, link_, request.command, words, ended)}});
}

/// What was said of a parked machine is true no longer.
void JobService::note_moved(const MachineOrder& order, const std::vector<std::string>& words) {
  constexpr std::string_view kKeeping[] = {"status", "override", "offsets", "settings"};
  if (changing_.job == 0 ||
      std::find(std::begin(kKeeping), std::end(kKeeping), order.name) != std::end(kKeeping))
    return;
  changing_.parked = "after `machine " + std::string(order.name) + (words.empty() ? "" : " " + words[0]) +
                     "`; `machine status` shows where it stands";
}

Result<std::string> JobService::follow_order(const ApiRequest& request) {
  if (request.order != worker_->number())
    return fail(Code::kUsage, "order " + std::to_string(request.order) +
                                  " is not the newest; its end is not known any more");
  if (request.held) worker_->renew();
  if (request.stop) worker_->stop();
  const auto ended = worker_->end();
  if (!ended) return order_reply({{"order", request.order}, {"in_work", true}});
  if (!*ended) return tl::unexpected<Error>(ended->error());
  return order_reply(
      {{"order", request.order}, {"text", (*ended)->text}, {"result", ordered_json::parse((*ended)->json)}});
}

Result<std::string> JobService::while_running(const MachineOrder& order,
                                              const std::vector<std::string>& words) {
  const RunView view = runner_->view();
  if (!order.while_running)
    return fail(Code::kUsage, std::string(order.name) + " is not possible while job " +
                                  std::to_string(view.job) + " is on the machine; status, " +
                                  (can_order(link_.kind, "override") ? "override, " : "") +
                                  "`tiltfeed hold`, `resume` and `stop` are");
  if (std::string(order.name) == "status") return order_reply(status_of(view));
  const Result<OperatorCommand> command = override_of(words);
  if (!command) return tl::unexpected<Error>(command.error());
  if (const Result<void> can = can_override(*command, view); !can) return tl::unexpected<Error>(can.error());
  runner_->command(*command);
  return order_reply({{"text", told()}, {"result", ordered_json::object()}});
}

/// hold, resume, stop without a number.
Result<SpooledJob> JobService::job_on_machine() {
  if (runner_->busy()) return spool_.find(runner_->view().job);
  if (changing_.job != 0) return spool_.find(changing_.job);
  return fail(Code::kUsage,
              "no job is on the machine; name a job by its number; " + still_advice(link_.kind));
}

}  // namespace tiltfeed::daemon
