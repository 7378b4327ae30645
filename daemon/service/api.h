#pragma once
// What a client may say to the service: one JSON object a line, version 1, over a Unix socket.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

inline constexpr int kApiVersion = 1;
/// Longest request line, bytes: files travel as descriptors, not as text.
inline constexpr std::size_t kMaxRequest = 4096;

/// A controller that was not heard for so long is told of, s: over every link but a drip feed it is asked
/// more often.
inline constexpr double kToldSilent = 3.0;

enum class ApiOp : std::uint8_t {
  kSubmit,
  kList,
  kShow,
  kStart,
  kHold,
  kResume,
  kStop,
  kRemove,
  kOverride,
  kReset,
  kMachine,
  kTool,
  kHistory
};

struct ApiRequest {
  ApiOp op = ApiOp::kList;
  std::uint64_t job = 0;               ///< 0: none given; of hold, resume, stop: that on the machine
  std::string name;                    ///< submit
  bool program = false;                ///< submit: a program, not a job to plan
  std::optional<std::uint64_t> block;  ///< show: what is known of this block
  std::optional<std::uint64_t> from;   ///< resume: re-enter before this block; history: after this run
  bool queue = false;                  ///< start: wait for its turn where the machine is busy
  bool confirmed = false;              ///< resume --from, reset: what will happen was shown and agreed to
  int percent = 100;                   ///< override
  std::string command, words;          ///< machine, tool: what is asked of it
  std::uint64_t order = 0;             ///< machine: the number that a command was given; 0: a new one
  bool held = false, stop = false;     ///< machine: the key is still held; the command is to end
};

/// {"v":1,"op":"start","job":3} and so on: see daemon/service/README.md. Errors: kUsage with what is wrong.
/// Never deeper than one object of plain values, never longer than kMaxRequest.
Result<ApiRequest> parse_request(std::string_view line);
std::string write_request(const ApiRequest& request);
/// {"v":1,"ok":true,"text":"..."}, a line. `key`: in the place of "text".
std::string write_text(const std::string& text, const char* key = "text");
/// With the job that begins: whether the controller takes it is not known yet.
std::string write_begun(std::uint64_t job, const std::string& text, const std::string& way_in = "");
/// {"v":1,"ok":false,"error":"..."}, a line.
std::string write_refusal(const Error& error);

}  // namespace tiltfeed::daemon
