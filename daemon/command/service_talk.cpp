#include "daemon/command/service_talk.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/service/api_socket.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kTakenInterval{50};

/// A run that ends before it is taken shows its last phase a moment, too.
bool has_taken(const std::string& phase) {
  constexpr const char* kTaken[] = {"run", "hold", "operator stop", "drain", "stop", "done"};
  return std::find(std::begin(kTaken), std::end(kTaken), phase) != std::end(kTaken);
}

}  // namespace

Result<std::string> ask_json(const std::string& socket, const ApiRequest& request,
                             const std::vector<int>& files) {
  Result<std::string> line = ask_service(socket, write_request(request), files);
  if (!line) return line;
  const json answer = json::parse(*line, nullptr, false);
  if (!answer.is_object()) return fail(Code::kIo, socket + ": the answer is not understood");
  if (!answer.value("ok", false)) return fail(Code::kInput, answer.value("error", "refused"));
  return line;
}

bool is_over(const std::string& state) {
  constexpr const char* kGoesOn[] = {"received", "planning", "queued", "running", "tool change"};
  return std::find(std::begin(kGoesOn), std::end(kGoesOn), state) == std::end(kGoesOn);
}

Result<std::string> until_taken(const std::string& socket, const std::string& answer,
                                const std::string& taken) {
  const json begun = json::parse(answer);
  if (!begun.contains("begins")) return answer;
  ApiRequest request;
  request.op = ApiOp::kShow;
  request.job = begun.value("begins", std::uint64_t{0});
  for (;;) {
    const Result<std::string> line = ask_json(socket, request);
    if (!line) return line;
    json shown = json::parse(*line);
    const std::string state = shown.value("state", ""), note = shown.value("note", "");
    if (state == "tool change") {
      shown["text"] = state + ": " + note;
      return shown.dump();
    }
    if (state == "done" || has_taken(shown.value("phase", "connect"))) {
      shown["text"] = taken;
      return shown.dump();
    }
    if (is_over(state))
      return fail(Code::kLink, "job " + std::to_string(request.job) + " is " + state + ": " + note);
    std::this_thread::sleep_for(kTakenInterval);
  }
}

}  // namespace tiltfeed::daemon
