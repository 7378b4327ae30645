#include "daemon/metrics/metrics.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "daemon/protocol/session.h"
#include "daemon/service/api.h"
#include "daemon/service/api_socket.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::json;
constexpr int kMostPages = 100;
constexpr double kPercent = 0.01, kMmInMetre = 1000.0, kSecondsInMinute = 60.0;
/// As `list` names them; those of the spool and those that only a service knows.
constexpr const char* kStates[] = {"received", "arriving", "planning",    "ready",
                                   "queued",   "running",  "interrupted", "uncertain",
                                   "done",     "stopped",  "failed",      "tool change"};
/// Of a run: key of the answer, name, what it is.
struct RunFigure {
  const char *key, *name, *help;
};
constexpr RunFigure kRunFigures[] = {
    {"blocks", "run_blocks", "Blocks of the program on the machine."},
    {"sent", "run_sent_blocks", "Blocks of it that were given to the wire."},
    {"acknowledged", "run_acknowledged_blocks", "Blocks of it that the controller has taken over."},
    {"executed", "run_executed_blocks", "Blocks of it that are surely executed."},
    {"resends", "run_resends", "Requests or lines of this run that were sent again."},
    {"seconds", "run_elapsed_seconds", "Time since the run started or went on."},
    {"starved_seconds", "run_starved_seconds",
     "Time in which the controller had run out although blocks were left to send."},
    {"slowest_hold_seconds", "run_slowest_hold_seconds",
     "The slowest answer to an order to hold, from the order to the controller's word."},
    {"remaining_seconds", "run_remaining_seconds", "Time left, by machine time as this run keeps to it."},
};

std::string label(const std::string& name, const std::string& value) {
  std::string out = name + "=\"";
  for (const char c : value)
    out += c == '\\' || c == '"' ? std::string("\\") + c : c == '\n' ? "\\n" : std::string(1, c);
  return out + "\"";
}

/// Families one after the other.
class Exposition {
 public:
  void family(const std::string& name, const std::string& help) {
    name_ = "tiltfeed_" + name;
    const char* const type = name.ends_with("_total") ? " counter\n" : " gauge\n";
    text += "# HELP " + name_ + " " + help + "\n# TYPE " + name_ + type;
  }
  void sample(double value, const std::string& labels = {}) {
    text += name_ + (labels.empty() ? "" : "{" + labels + "}") + " " + json(value).dump() + "\n";
  }
  void single(const std::string& name, const std::string& help, double value) {
    family(name, help);
    sample(value);
  }
  std::string text;

 private:
  std::string name_;
};

/// One sample for each of these words, and for others that the answer has.
void tell_words(const std::string& name, const std::string& help, const char* of,
                std::vector<std::string> words, const json& counts, Exposition& out) {
  for (const auto& [word, count] : counts.items())
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  out.family(name, help);
  for (const std::string& word : words) out.sample(counts.value(word, 0.0), label(of, word));
}

/// Of what has ended since the service began. Of plans nothing is told where there is no shop.
void tell_counts(const json& counts, Exposition& out) {
  const auto of = [&](const char* key) { return counts.value(key, json::object()); };
  tell_words("runs_total", "Runs that have ended since the service began, by what became of them.", "outcome",
             {"done", "stopped", "failed", "interrupted", "uncertain", "tool change", "nothing sent"},
             of("runs"), out);
  if (!counts.contains("plans_asked")) return;
  tell_words("plans_asked", "Jobs of this machine whose plans other machines are asked for now.", "state",
             {"open", "taken", "proving"}, of("plans_asked"), out);
  tell_words("plans_asked_ended_total",
             "Plans that were asked for: accepted after a proof here, refused, or not taken by anybody.",
             "outcome", {"accepted", "refused", "not taken"}, of("plans_asked_ended"), out);
  out.single("plans_for_others", "1: this machine is idle and plans for another one.",
             counts.value("plans_for_others", 0.0));
  tell_words("plans_for_others_ended_total",
             "Plans for other machines: done, failed, or given back since the processor was needed here.",
             "outcome", {"done", "failed", "given back"}, of("plans_for_others_ended"), out);
}

void tell_run(const json& job, Exposition& out) {
  out.family("run_phase", "1 at the phase that the run on the machine is in.");
  for (int i = 0; i <= static_cast<int>(Phase::kFault); ++i) {
    const std::string name = phase_name(static_cast<Phase>(i));
    out.sample(job.value("phase", "") == name ? 1 : 0, label("phase", name));
  }
  for (const RunFigure& one : kRunFigures)
    if (job.contains(one.key)) out.single(one.name, one.help, job.value(one.key, 0.0));
  const double taken = job.value("acknowledged", 0.0), executed = job.value("executed", 0.0);
  out.single("run_buffered_blocks", "Blocks that the controller has and that are not known to be executed.",
             std::max(0.0, taken - executed));
  if (job.contains("feed_mm_per_min"))
    out.single("run_feed_meters_per_second", "Speed along the path, as the controller reports it.",
               job.value("feed_mm_per_min", 0.0) / (kMmInMetre * kSecondsInMinute));
  if (job.contains("spindle_rpm"))
    out.single("run_spindle_hertz", "Turns of the spindle a second, as the controller reports it.",
               job.value("spindle_rpm", 0.0) / kSecondsInMinute);
  const json overrides = job.value("override", json::object());
  if (overrides.empty()) return;
  out.family("override_ratio", "As the controller reports it.");
  for (const auto& [kind, percent] : overrides.items())
    out.sample(percent.get<double>() * kPercent, label("kind", kind));
}

void tell_jobs(const std::vector<json>& answers, Exposition& out) {
  std::map<std::string, int> count;
  int waiting = 0;
  bool moves = false;
  const json* run = nullptr;
  for (const json& answer : answers)
    for (const json& job : answer.at("jobs")) {
      ++count[job.value("state", "")];
      if (job.contains("queue")) ++waiting, moves = moves || job.value("queue_moves", false);
      if (job.contains("phase")) run = &job;
    }
  out.family("machine_info", "The machine of this service, and its wire.");
  out.sample(1, label("machine", answers[0].value("machine", "")) + "," +
                    label("link", answers[0].value("link", "")));
  out.family("jobs", "Jobs in the spool by state: failed, interrupted and uncertain want an operator.");
  for (const char* const state : kStates) out.sample(count[state], label("state", state));
  out.single("queue_jobs", "Jobs that wait for their turn on the machine.", waiting);
  out.single("queue_moving", "1: the next in the queue starts when the run ends.", moves ? 1 : 0);
  tell_counts(answers[0].value("counts", json::object()), out);
  if (run != nullptr) tell_run(*run, out);
}

}  // namespace

Result<std::string> metrics_text(const std::vector<std::string>& answers, const std::string& version,
                                 const SpoolRoom& room) {
  Exposition out;
  out.family("build_info", "1, with the version of the program that asked.");
  out.sample(1, label("version", version));
  out.single("up", "1: the service answers on its socket.", answers.empty() ? 0 : 1);
  out.single("spool_free_bytes", "Room on the disk of the spool.", static_cast<double>(room.free_bytes));
  out.single("spool_size_bytes", "Size of that disk.", static_cast<double>(room.size_bytes));
  try {
    std::vector<json> read;
    for (const std::string& answer : answers) read.push_back(json::parse(answer));
    if (!read.empty()) tell_jobs(read, out);
  } catch (const json::exception& error) {
    return fail(Code::kIo, std::string("the service's answer is not understood: ") + error.what());
  }
  return out.text;
}

std::vector<std::string> all_answers(const std::string& socket) {
  std::vector<std::string> answers;
  ApiRequest request;
  for (int page = 0; page < kMostPages; ++page) {
    const Result<std::string> line = ask_service(socket, write_request(request), {}, kShortPatience);
    if (!line) return {};
    answers.push_back(*line);
    const json answer = json::parse(*line, nullptr, false);
    if (!answer.is_object() || !answer.value("more", false) || answer["jobs"].empty()) break;
    request.job = answer["jobs"].back().value("job", std::uint64_t{0});
  }
  return answers;
}

}  // namespace tiltfeed::daemon
