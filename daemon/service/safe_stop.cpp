#include "daemon/service/safe_stop.h"

#include <cstdlib>
#include <filesystem>

#include "config/service_config.h"
#include "daemon/journal/journal.h"
#include "daemon/journal/run_recorder.h"
#include "daemon/machine/order_mark.h"
#include "daemon/machine/stop_machine.h"
#include "daemon/service/spool.h"
#include "daemon/service/state_lock.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"

namespace tiltfeed::daemon {

namespace {

constexpr const char* kDripText =
    "nothing was sent: a CNC control takes no hold and no M5 from the wire that feeds it. It stands when the "
    "blocks that it has are cut, with the spindle on: press feed hold and reset at the control";
constexpr const char* kWatchdogText =
    "nothing was sent: the controller's own watchdog holds the machine when the heartbeat stands still; "
    "spindle and coolant stay as they are";

/// Something of the run may be in the controller, and it has not come to its end in order. Also where the
/// journal cannot show it.
bool may_move(const JournalContent& journal) {
  if (!journal.whole()) return true;
  const RunRecord& last = *journal.last;
  // Beside a tool change a job runs only while it parks or goes back: also where no block of its own has
  // left.
  if (last.event == RunEvent::kToolChange) return true;
  return last.offered > 0 && last.event != RunEvent::kExecuted && last.event != RunEvent::kStopped;
}

/// What was on the machine: a job's number, a command of the operator, or why that is not known.
struct OnMachine {
  std::uint64_t job = 0;
  std::string order = {}, unknown = {};
};

std::string text_of(const OnMachine& what) {
  if (what.job > 0) return "job " + std::to_string(what.job);
  if (!what.order.empty()) return "machine " + what.order;
  return "what was on the machine cannot be read (" + what.unknown + ")";
}

/// A command that may have moved the machine when the service died. Errors: kInput.
Result<std::optional<OnMachine>> order_on_machine(const config::ServiceConfig& config, LinkKind kind) {
  const auto marked = marked_order(config.spool);
  if (!marked) return std::nullopt;
  if (!marked->link) return OnMachine{0, "", marked->text};
  if (*marked->link == kind) return OnMachine{0, marked->text, ""};
  return fail(Code::kInput, config.path + ": machine " + marked->text +
                                " was in work over another kind of link than the one stated now; nothing was "
                                "sent: stop the machine by hand");
}

/// Nothing where the spool has none. A spool that cannot be read is no proof of that. Errors: kUsage, kIo.
Result<std::optional<OnMachine>> job_on_machine(const config::ServiceConfig& config, LinkKind kind) {
  std::error_code none;
  if (!std::filesystem::exists(config.spool + "/jobs", none)) return std::nullopt;
  const Result<Spool> spool = Spool::open(config.spool);
  if (!spool && spool.error().code == Code::kUsage)
    return fail(
        spool.error().code,
        spool.error().message + "; nothing was sent (while a service lives: tiltfeed hold, tiltfeed stop)");
  const auto jobs = spool ? spool->list() : tl::unexpected<Error>(spool.error());
  if (!jobs) return OnMachine{0, "", jobs.error().message};
  for (const SpooledJob& job : *jobs) {
    if (job.state != JobState::kRunning) continue;
    const Result<JournalContent> journal = read_journal_file(spool->file(job.id, "journal"));
    if (!journal)
      return fail(Code::kIo,
                  journal.error().message +
                      "; nothing was sent (while the service lives: tiltfeed hold, tiltfeed stop)");
    if (!may_move(*journal)) continue;
    if (journal->last && journal->last->link != static_cast<std::uint8_t>(kind))
      return fail(Code::kInput,
                  config.path + ": job " + std::to_string(job.id) +
                      " ran over another kind of link than the one stated now; nothing was sent: stop "
                      "the machine by hand");
    return OnMachine{job.id};
  }
  return order_on_machine(config, kind);
}

}  // namespace

ServiceEnd service_end() {
  const auto value = [](const char* name) {
    const char* text = std::getenv(name);
    return std::string(text != nullptr ? text : "");
  };
  return {value("SERVICE_RESULT"), value("EXIT_CODE"), value("EXIT_STATUS")};
}

bool in_order(const ServiceEnd& end) {
  return end.result == "success" && end.code == "exited" && end.status == "0";
}

Result<SafeStop> safe_stop(const std::string& config_path, const ServiceEnd& end) {
  if (in_order(end)) return SafeStop{"", "the service ended in order; nothing was sent", 0};
  const Result<config::ServiceConfig> config = config::load_service_config(config_path);
  if (!config) return tl::unexpected<Error>(config.error());
  const Result<LinkSpec> link = parse_link(config->link, config->machine.wire);
  if (!link) return tl::unexpected<Error>(link.error());
  const auto job = job_on_machine(*config, link->kind);
  if (!job) return tl::unexpected<Error>(job.error());
  SafeStop stop{config->machine.model.name, "no job was on the machine; nothing was sent", 0};
  if (!*job) return stop;
  stop.job = (*job)->job;
  stop.due = true;
  const std::string name = text_of(**job) + ", " + describe(*link) + ": ";
  // Of a spool that cannot be read nobody knows whose it is.
  MachineClaim claim;
  if (!(*job)->unknown.empty())
    if (const Result<void> free = claim.follow(*link); !free)
      return fail(free.error().code, name + free.error().message + "; nothing was sent");
  stop.text = name + kWatchdogText;
  if (is_provable(link->kind)) return stop;
  if (link->kind == LinkKind::kDrip) return fail(Code::kLink, name + kDripText);
  const Result<std::unique_ptr<Link>> wire = open_link(*link);
  if (!wire) return fail(wire.error().code, name + wire.error().message);
  SteadyClock clock;
  const Result<std::string> stopped = stop_machine(*link, **wire, clock);
  if (!stopped) return fail(stopped.error().code, name + stopped.error().message);
  stop.text = name + *stopped;
  clear_order_mark(config->spool);
  return stop;
}

}  // namespace tiltfeed::daemon
