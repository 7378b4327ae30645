#include "daemon/command/service_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "config/machine_profile.h"
#include "config/service_config.h"
#include "daemon/command/command.h"
#include "daemon/command/doctor_command.h"
#include "daemon/command/service_talk.h"
#include "daemon/command/submit_command.h"
#include "daemon/machine/machine_place.h"
#include "daemon/machine/tool_guide.h"
#include "daemon/service/api.h"
#include "daemon/service/api_socket.h"
#include "daemon/service/notify.h"
#include "daemon/service/safe_stop.h"
#include "daemon/service/service.h"
#include "daemon/service/spool_backup.h"
#include "daemon/service/state_lock.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;
constexpr std::chrono::milliseconds kWatchInterval{500}, kResetInterval{50};
constexpr const char* kEntryQuestion =
    "Is the tool clear, the machine homed, the tool in the spindle the one of that block? Type yes to move: ";

std::string duration(double seconds) {
  const long s = static_cast<long>(seconds + 0.5);
  char text[40];
  std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  return text;
}

/// A value for people: "x 1.5, y 2", "3, 5".
std::string plain_text(const ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_structured()) return value.dump();
  std::string text;
  for (const auto& [key, part] : value.items())
    text += (text.empty() ? "" : ", ") + (value.is_object() ? key + " " : "") + plain_text(part);
  return text;
}

/// In a column so many characters wide.
std::string padded(std::string text, std::size_t width) {
  const auto bytes_inside = std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; });
  width += static_cast<std::size_t>(bytes_inside);
  if (text.size() < width) text.resize(width, ' ');
  return text;
}

void print_job(const ordered_json& job) {
  const auto total = job.value("blocks", std::uint64_t{0}), done = job.value("executed", std::uint64_t{0});
  std::printf("%6llu  %-11s %s %llu of %llu blocks",
              static_cast<unsigned long long>(job.value("job", std::uint64_t{0})),
              job.value("state", "").c_str(), padded(job.value("name", ""), 24).c_str(),
              static_cast<unsigned long long>(done), static_cast<unsigned long long>(total));
  if (job.contains("queue"))
    std::printf(", place %llu of the queue%s",
                static_cast<unsigned long long>(job.value("queue", std::uint64_t{0})),
                job.value("queue_moves", false) ? "" : ", which stands still");
  if (job.contains("stage"))
    std::printf(", %s %d %%", job.value("stage", "").c_str(), job.value("percent", 0));
  if (job.contains("phase")) {
    std::printf(", %s", job.value("phase", "").c_str());
    if (job.value("machine_seconds", 0.0) > 0.0)
      std::printf(", %s left", duration(job.value("remaining_seconds", 0.0)).c_str());
  }
  if (const double silent = job.value("silent_seconds", 0.0); silent > kToldSilent)
    std::printf(", the controller was last heard %.0f s ago", silent);
  if (const std::string held = job.value("held", ""); !held.empty()) std::printf(", %s", held.c_str());
  if (const std::string note = job.value("note", ""); !note.empty()) std::printf("  (%s)", note.c_str());
  std::printf("\n");
}

}  // namespace

struct ServiceCommands::Options {
  CLI::App *serve = nullptr, *safe_stop = nullptr, *list = nullptr, *show = nullptr, *start = nullptr,
           *hold = nullptr, *resume = nullptr, *stop = nullptr, *remove = nullptr, *watch = nullptr,
           *override_feed = nullptr, *reset = nullptr, *backup = nullptr;
  std::unique_ptr<SubmitCommand> submit;
  std::string config, socket, link, machine, to, version;
  std::uint64_t job = 0, block = 0, from = 0;
  int percent = 100;
  bool yes = false, queue = false, as_json = false, check = false;

  Result<ordered_json> ask(const ApiRequest& request, const std::vector<int>& files = {}) const;
  int simple(ApiOp op);
  int tell(const ordered_json& answer, const std::string& text) const;
  int tell_taken(const Result<ordered_json>& answer, const std::string& taken) const;
  int run_list();
  int run_show();
  int run_resume();
  int run_watch();
  int run_start();
  int run_reset();
  int reset_here();
  bool agreed(const std::string& what, const char* question) const;
  int run_safe_stop() const;
  int run_backup() const;
};

ServiceCommands::ServiceCommands(CLI::App& app, const std::string& version)
    : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.version = version;
  o.socket = service_socket();
  o.serve = app.add_subcommand("serve", "run the service of one machine");
  o.serve->add_option("--config", o.config, "its file (YAML)")->required();
  o.serve->add_flag("--check", o.check, "read and judge the file, show what it comes to, start nothing");
  o.serve->add_flag("--json", o.as_json, "of --check: print one JSON object")->needs("--check");
  o.safe_stop = app.add_subcommand("safe-stop", "hold the machine that a service left moving when it died");
  o.safe_stop->add_option("--config", o.config, "the service's file (YAML)")->required();
  o.safe_stop->add_flag("--json", o.as_json, "print one JSON object besides the log");
  o.backup = app.add_subcommand("backup", "copy the service's jobs, which may be at work meanwhile");
  o.backup->add_option("--config", o.config, "the service's file (YAML)")->required();
  o.backup->add_flag("--json", o.as_json, "print one JSON object");
  o.backup->add_option("FOLDER", o.to, "the copy; not there yet")->required();
  const auto client = [&](const char* name, const char* text, bool job) {
    CLI::App* command = app.add_subcommand(name, text);
    command->add_option(
        "--socket", o.socket,
        "the service's socket (default: $TILTFEED_SOCKET, else " + std::string(kDefaultSocket) + ")");
    command->add_flag("--json", o.as_json, "print one JSON object, of watch one a line");
    if (job) command->add_option("JOB", o.job, "its number")->required();
    return command;
  };
  const auto on_machine = [&](const char* name, const char* text) {
    CLI::App* command = client(name, text, false);
    command->add_option("JOB", o.job, "its number; else the job on the machine")->check(above_zero);
    return command;
  };
  o.submit = std::make_unique<SubmitCommand>(app);
  o.list = client("list", "the jobs of the service", false);
  o.show = client("show", "one job, and what a block of it is", true);
  o.show->add_option("--block", o.block, "from the block back to the part");
  o.start = client("start", "begin to move: the operator's word", true);
  o.start->add_flag("--queue", o.queue,
                    "where the machine is busy, wait: it starts by itself when all before it are executed to "
                    "their ends; after a stop, a fault or a restart nothing does, until a start");
  o.hold = on_machine("hold", "feed hold; without a number it ends a machine command, too");
  o.resume = on_machine("resume", "end a hold, or go on with a job that was cut off");
  o.resume->add_option("--from", o.from, "enter again before this block")->check(above_zero);
  o.resume->add_flag("--yes", o.yes, "do not ask after showing how it is entered");
  o.stop = on_machine(
      "stop",
      "hold, then forget the rest; or take it out of the queue; without a number a machine command, too");
  o.remove = client("remove", "forget a job and its files", true);
  o.watch = client("watch", "follow a job until it ends", true);
  o.reset =
      client("reset", "lead the machine out of a hold, an alarm, check mode or a run nobody feeds", false);
  o.reset->add_flag("--yes", o.yes, "do not ask after showing what it does");
  o.reset->add_option("--link", o.link, "without a service: over this link");
  o.reset->add_option("--machine", o.machine, "without a service: machine profile (YAML)");
  o.override_feed = client("override", "feed override", true);
  o.override_feed->add_option("PERCENT", o.percent, "10 to 200")->required()->check(CLI::Range(10, 200));
}

ServiceCommands::~ServiceCommands() = default;

Result<ordered_json> ServiceCommands::Options::ask(const ApiRequest& request,
                                                   const std::vector<int>& files) const {
  const Result<std::string> line = ask_json(socket, request, files);
  if (!line) return tl::unexpected<Error>(line.error());
  return ordered_json::parse(*line);
}

int ServiceCommands::Options::simple(ApiOp op) {
  ApiRequest request;
  request.op = op;
  request.job = job;
  request.percent = percent;
  request.queue = queue;
  const Result<ordered_json> answer = ask(request);
  const bool ends = op == ApiOp::kHold || op == ApiOp::kStop;
  if (!answer && ends && answer.error().code != Code::kInput)  // a refusal
    return complain({answer.error().code, answer.error().message + "; hold the machine at its own control"});
  if (!answer) return complain(answer.error());
  return tell(*answer, answer->value("text", ""));
}

int ServiceCommands::Options::tell(const ordered_json& answer, const std::string& text) const {
  std::cout << (as_json ? answer.dump(-1, ' ', true, ordered_json::error_handler_t::replace) : text) << "\n";
  return kExitDone;
}

int ServiceCommands::Options::run_list() {
  ApiRequest request;
  request.op = ApiOp::kList;
  Result<ordered_json> answer = ask(request);
  while (answer && answer->value("more", false)) {
    request.job = (*answer)["jobs"].back().value("job", std::uint64_t{0});
    Result<ordered_json> next = ask(request);
    if (!next) return complain(next.error());
    ordered_json jobs = std::move((*answer)["jobs"]);
    for (ordered_json& one : (*next)["jobs"]) jobs.push_back(std::move(one));
    (*next)["jobs"] = std::move(jobs);
    answer = std::move(next);
  }
  if (!answer) return complain(answer.error());
  if (as_json) return tell(*answer, "");
  std::cout << answer->value("machine", "") << " at " << answer->value("link", "") << "\n";
  if (answer->contains("shop")) std::cout << "shop's queue: " << answer->value("shop", "") << "\n";
  for (const ordered_json& one : (*answer)["jobs"]) print_job(one);
  return kExitDone;
}

int ServiceCommands::Options::run_show() {
  ApiRequest request;
  request.op = ApiOp::kShow;
  request.job = job;
  if (block > 0) request.block = block;
  const Result<ordered_json> answer = ask(request);
  if (!answer) return complain(answer.error());
  const bool found = !answer->contains("origin") || !(*answer)["origin"].contains("error");
  const int status = found ? kExitDone : kExitFailed;
  if (as_json) return tell(*answer, ""), status;
  for (const auto& [key, value] : answer->items()) {
    if (key == "v" || key == "ok") continue;
    const bool time = key == "submitted" && value.is_number();
    std::cout << key << ": " << (time ? utc_text(value.get<std::time_t>()) : plain_text(value)) << "\n";
  }
  return status;
}

int ServiceCommands::Options::run_resume() {
  ApiRequest request;
  request.op = ApiOp::kResume;
  request.job = job;
  if (from > 0) request.from = from;
  Result<ordered_json> answer = ask(request);
  if (!answer) return complain(answer.error());
  if (answer->contains("confirm")) {
    if (!agreed(answer->value("confirm", ""), from > 0 ? kEntryQuestion : kBackQuestion))
      return complain({Code::kCancelled, "nothing was sent"});
    request.confirmed = true;
    answer = ask(request);
  }
  if (!answer) return complain(answer.error());
  const std::string begun = std::to_string(answer->value("begins", job));
  return tell_taken(std::move(answer), from > 0            ? "re-entered as job " + begun
                                       : request.confirmed ? "the controller has taken the way back"
                                                           : "the controller goes on with it");
}

bool ServiceCommands::Options::agreed(const std::string& what, const char* question) const {
  std::ostream& out = as_json ? std::cerr : std::cout;  // the object stands alone
  out << what;
  if (yes) return true;
  out << question << std::flush;
  std::string word;
  std::getline(std::cin, word);
  return word == "yes";
}

int ServiceCommands::Options::run_start() {
  ApiRequest request;
  request.op = ApiOp::kStart;
  request.job = job;
  request.queue = queue;
  Result<ordered_json> answer = ask(request);
  const std::string way_in = answer ? answer->value("way_in", "") : "";
  return tell_taken(std::move(answer), way_in.empty() ? "started" : "started; " + way_in);
}

/// Tells what became of it once the controller has taken it, or has refused.
int ServiceCommands::Options::tell_taken(const Result<ordered_json>& answer, const std::string& taken) const {
  if (!answer) return complain(answer.error());
  const Result<std::string> ended = until_taken(socket, answer->dump(), taken);
  if (!ended) return complain(ended.error());
  const ordered_json shown = ordered_json::parse(*ended);
  return tell(shown, shown.value("text", ""));
}

/// Without a service.
int ServiceCommands::Options::reset_here() {
  config::MachineProfile profile;
  if (!machine.empty()) {
    auto loaded = config::load_machine(machine);
    if (!loaded) return complain(loaded.error());
    profile = std::move(*loaded);
  }
  const auto spec = parse_link(link.empty() ? profile.link : link, profile.wire);
  if (!spec) return complain(spec.error());
  if (!agreed(reset_preview(*spec), "Type yes to reset: "))
    return complain({Code::kCancelled, "nothing was sent"});
  MachineClaim claim;  // a serial port is locked by opening it; an address is not
  if (spec->over_network())
    if (const Result<void> mine = claim.follow(*spec); !mine) return complain(mine.error());
  const Result<std::unique_ptr<Link>> wire = open_link(*spec);
  if (!wire) return complain(wire.error());
  SteadyClock clock;
  const Result<std::string> done = reset_machine(*spec, **wire, clock);
  if (!done) return complain(done.error());
  if (as_json) return tell({{"ok", true}, {"reset", *done}}, "");
  std::cout << *done << "\n";
  return kExitDone;
}

int ServiceCommands::Options::run_reset() {
  if (!link.empty() || !machine.empty()) return reset_here();
  ApiRequest request;
  request.op = ApiOp::kReset;
  Result<ordered_json> answer = ask(request);
  if (!answer) return complain(answer.error());
  if (!agreed(answer->value("confirm", ""), "Type yes to reset: "))
    return complain({Code::kCancelled, "nothing was sent"});
  request.confirmed = true;
  if (answer = ask(request); !answer) return complain(answer.error());
  request.op = ApiOp::kList;
  std::string text = "in work";
  while (text == "in work") {
    std::this_thread::sleep_for(kResetInterval);
    if (answer = ask(request); !answer) return complain(answer.error());
    text = answer->value("reset", "");
  }
  tell(*answer, text);
  return text.starts_with("done") ? kExitDone : kExitFailed;
}

int ServiceCommands::Options::run_watch() {
  for (;;) {
    ApiRequest request;
    request.op = ApiOp::kShow;
    request.job = job;
    const Result<ordered_json> answer = ask(request);
    if (!answer) return complain(answer.error());
    if (as_json)
      tell(*answer, "");
    else
      print_job(*answer);
    std::cout << std::flush;
    const std::string state = answer->value("state", "");
    if (is_over(state)) return state == "done" || state == "ready" ? kExitDone : kExitFailed;
    std::this_thread::sleep_for(kWatchInterval);
  }
}

int ServiceCommands::Options::run_safe_stop() const {
  const Result<SafeStop> stopped = daemon::safe_stop(config, service_end());
  LogFields fields;
  if (!stopped)
    return write_log(Severity::kError, "safe-stop: " + stopped.error().message, fields), kExitFailed;
  fields.machine = stopped->machine;
  fields.job = stopped->job;
  write_log(stopped->due ? Severity::kWarning : Severity::kInfo, "safe-stop: " + stopped->text, fields);
  if (as_json)
    return tell({{"ok", true}, {"job", stopped->job}, {"machine", stopped->machine}, {"text", stopped->text}},
                "");
  return kExitDone;
}

int ServiceCommands::Options::run_backup() const {
  const Result<config::ServiceConfig> service = config::load_service_config(config);
  if (!service) return complain(service.error());
  const Result<std::uint64_t> jobs = back_up(service->spool, to);
  if (!jobs) return complain(jobs.error());
  if (as_json) return tell({{"ok", true}, {"folder", to}, {"jobs", *jobs}}, "");
  std::cout << to << ": " << *jobs << " jobs, without the journals of their runs\n";
  return kExitDone;
}

std::optional<int> ServiceCommands::run() {
  Options& o = *options_;
  if (o.serve->parsed()) {
    if (o.check) return check_service(o.config, o.as_json);
    const Result<void> served = serve(o.config, o.version);
    return served ? kExitDone : complain(served.error());
  }
  if (o.safe_stop->parsed()) return o.run_safe_stop();
  if (o.backup->parsed()) return o.run_backup();
  if (o.submit->called()) return o.submit->run();
  if (o.list->parsed()) return o.run_list();
  if (o.show->parsed()) return o.run_show();
  if (o.resume->parsed()) return o.run_resume();
  if (o.watch->parsed()) return o.run_watch();
  if (o.start->parsed()) return o.run_start();
  if (o.reset->parsed()) return o.run_reset();
  if (o.hold->parsed()) return o.simple(ApiOp::kHold);
  if (o.stop->parsed()) return o.simple(ApiOp::kStop);
  if (o.remove->parsed()) return o.simple(ApiOp::kRemove);
  if (o.override_feed->parsed()) return o.simple(ApiOp::kOverride);
  return std::nullopt;
}

}  // namespace tiltfeed::daemon
