#include "daemon/mtconnect/service_watch.h"

#include <nlohmann/json.hpp>

#include "daemon/metrics/metrics.h"
#include "daemon/service/api.h"
#include "daemon/service/api_socket.h"

namespace tiltfeed::daemon {
namespace {

using nlohmann::json;
constexpr std::size_t kLongestBlock = 256;  // of the text that is told

/// The answer, an object that says that it is one; else null.
json ask(const std::string& socket, const ApiRequest& request) {
  const Result<std::string> line = ask_service(socket, write_request(request), {});
  json answer = line ? json::parse(*line, nullptr, false) : json();
  return answer.is_object() && answer.value("ok", false) ? answer : json();
}

bool is_on_the_machine(const json& job) {
  return job.contains("phase") || job.value("state", "") == "tool change";
}

}  // namespace

std::string ProgramLine::read(const std::string& path, std::uint64_t number) {
  if (path != path_ || number < at_ || !in_) {
    path_ = path;
    in_ = std::ifstream(path);
    at_ = 0;
  }
  while (at_ < number && std::getline(in_, line_)) ++at_;
  return at_ == number && number > 0 ? line_.substr(0, kLongestBlock) : std::string();
}

std::optional<ServiceView> ServiceWatch::look() {
  ServiceView view;
  if (!(job_ != 0 && show_job(view)) && !(find_job() && read_history())) return std::nullopt;
  if (job_ != 0 && view.job.empty()) show_job(view);
  view.last = last_;
  view.parts = parts_;
  return view;
}

/// False where nobody answers.
bool ServiceWatch::find_job() {
  job_ = 0;
  const std::vector<std::string> answers = all_answers(socket_);
  for (const std::string& answer : answers) {
    const json read = json::parse(answer, nullptr, false);
    if (!read.is_object() || !read.value("ok", false)) return false;
    for (const json& job : read["jobs"])
      if (is_on_the_machine(job)) job_ = job.value("job", std::uint64_t{0});
  }
  return !answers.empty();
}

/// False where the job is not on the machine any more, or nobody answers.
bool ServiceWatch::show_job(ServiceView& view) {
  ApiRequest request;
  request.op = ApiOp::kShow;
  request.job = job_;
  const json job = ask(socket_, request);
  if (job.is_null() || !is_on_the_machine(job)) return false;
  const json lines = job.value("uncertain_lines", json::array());
  if (!lines.empty() && job.contains("folder"))
    view.block = program_.read(job["folder"].get<std::string>() + "/program.nc", lines[0]);
  view.job = job.dump();
  return true;
}

bool ServiceWatch::read_history() {
  for (;;) {
    ApiRequest request;
    request.op = ApiOp::kHistory;
    if (run_ != 0) request.from = run_;
    const json answer = ask(socket_, request);
    if (answer.is_null()) return false;
    for (const json& run : answer["runs"]) {
      if (run.value("outcome", "") == "running") return true;
      run_ = run.value("run", run_);
      parts_ += run.value("outcome", "") == "done" ? 1 : 0;
      last_ = run.dump();
    }
    if (!answer.value("more", false)) return true;
  }
}

}  // namespace tiltfeed::daemon
