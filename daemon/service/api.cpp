#include "daemon/service/api.h"

#include <nlohmann/json.hpp>

namespace tiltfeed::daemon {

namespace {

using nlohmann::json;

struct Name {
  const char* word;
  ApiOp op;
};
constexpr Name kOps[] = {
    {"submit", ApiOp::kSubmit},  {"list", ApiOp::kList},       {"show", ApiOp::kShow},
    {"start", ApiOp::kStart},    {"hold", ApiOp::kHold},       {"resume", ApiOp::kResume},
    {"stop", ApiOp::kStop},      {"remove", ApiOp::kRemove},   {"override", ApiOp::kOverride},
    {"reset", ApiOp::kReset},    {"machine", ApiOp::kMachine}, {"tool", ApiOp::kTool},
    {"history", ApiOp::kHistory}};
constexpr std::size_t kMaxText = 200, kMaxWords = 300;

tl::unexpected<Error> wrong(const std::string& what) { return fail(Code::kUsage, "request: " + what); }

/// Nothing nested is ever needed: an object in it ends the parse before it can grow.
bool shallow(std::string_view line) {
  int depth = 0;
  bool text = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (text) {
      if (line[i] == '\\')
        ++i;
      else if (line[i] == '"')
        text = false;
    } else if (line[i] == '"') {
      text = true;
    } else if (line[i] == '{' || line[i] == '[') {
      if (++depth > 1) return false;
    }
  }
  return true;
}

std::optional<std::uint64_t> count_of(const json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto number = value.get<std::uint64_t>();
  if (number > (1ull << 53)) return std::nullopt;  // what every JSON reader keeps exactly
  return number;
}

Result<void> take(const std::string& key, const json& value, ApiRequest& request) {
  if (key == "v" || key == "op") return {};
  if (key == "name" && value.is_string() && value.get_ref<const std::string&>().size() <= kMaxText) {
    request.name = value.get<std::string>();
    return {};
  }
  if ((key == "command" || key == "words") && value.is_string() &&
      value.get_ref<const std::string&>().size() <= kMaxWords) {
    (key == "command" ? request.command : request.words) = value.get<std::string>();
    return {};
  }
  if ((key == "held" || key == "stop") && value.is_boolean()) {
    (key == "held" ? request.held : request.stop) = value.get<bool>();
    return {};
  }
  if ((key == "program" || key == "confirmed" || key == "queue") && value.is_boolean()) {
    (key == "program" ? request.program
     : key == "queue" ? request.queue
                      : request.confirmed) = value.get<bool>();
    return {};
  }
  const std::optional<std::uint64_t> number = count_of(value);
  if (key == "job" && number) return request.job = *number, Result<void>{};
  if (key == "block" && number) return request.block = *number, Result<void>{};
  if (key == "order" && number) return request.order = *number, Result<void>{};
  if (key == "from" && number) return request.from = *number, Result<void>{};
  if (key == "percent" && number && *number >= 10 && *number <= 200)
    return request.percent = static_cast<int>(*number), Result<void>{};
  return wrong("'" + key.substr(0, kMaxText) + "' is unknown or its value is out of range");
}

}  // namespace

Result<ApiRequest> parse_request(std::string_view line) {
  if (line.size() > kMaxRequest) return wrong("longer than " + std::to_string(kMaxRequest) + " bytes");
  if (!shallow(line)) return wrong("only one object of plain values is expected");
  const json parsed = json::parse(line, nullptr, false);
  if (parsed.is_discarded() || !parsed.is_object()) return wrong("not a JSON object");
  const auto version = parsed.find("v");
  if (version == parsed.end() || count_of(*version) != std::uint64_t{kApiVersion})
    return wrong("\"v\" must be " + std::to_string(kApiVersion) + "; this service knows no other version");
  const auto op = parsed.find("op");
  if (op == parsed.end() || !op->is_string()) return wrong("\"op\" is missing");
  ApiRequest request;
  bool known = false;
  for (const Name& name : kOps)
    if (op->get_ref<const std::string&>() == name.word) request.op = name.op, known = true;
  if (!known) return wrong("\"op\" is unknown");
  for (const auto& [key, value] : parsed.items())
    if (const Result<void> taken = take(key, value, request); !taken)
      return tl::unexpected<Error>(taken.error());
  const bool needs_job = request.op == ApiOp::kShow || request.op == ApiOp::kStart ||
                         request.op == ApiOp::kRemove || (request.op == ApiOp::kResume && request.from);
  if (needs_job && request.job == 0) return wrong("\"job\" is missing");
  if (request.from && *request.from == 0) return wrong("\"from\" counts blocks from 1");
  return request;
}

std::string write_request(const ApiRequest& request) {
  json out = {{"v", kApiVersion}};
  for (const Name& name : kOps)
    if (request.op == name.op) out["op"] = name.word;
  if (request.job != 0) out["job"] = request.job;
  if (request.op == ApiOp::kSubmit) out["name"] = request.name, out["program"] = request.program;
  if (request.block) out["block"] = *request.block;
  if (request.from) out["from"] = *request.from;
  if (request.queue) out["queue"] = true;
  if (request.op == ApiOp::kMachine) {
    if (request.order != 0)
      out["order"] = request.order;
    else
      out["command"] = request.command, out["words"] = request.words;
    if (request.held) out["held"] = true;
    if (request.stop) out["stop"] = true;
  }
  if (request.op == ApiOp::kTool) out["command"] = request.command, out["words"] = request.words;
  if (request.confirmed) out["confirmed"] = true;
  if (request.op == ApiOp::kOverride) out["percent"] = request.percent;
  return out.dump(-1, ' ', true, json::error_handler_t::replace) + "\n";
}

std::string write_text(const std::string& text, const char* key) {
  const nlohmann::ordered_json out = {{"v", kApiVersion}, {"ok", true}, {key, text}};
  return out.dump(-1, ' ', true, json::error_handler_t::replace) + "\n";
}

std::string write_begun(std::uint64_t job, const std::string& text, const std::string& way_in) {
  nlohmann::ordered_json out = {{"v", kApiVersion}, {"ok", true}, {"text", text}, {"begins", job}};
  if (!way_in.empty()) out["way_in"] = way_in;
  return out.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string write_refusal(const Error& error) {
  const json out = {{"v", kApiVersion}, {"ok", false}, {"error", error.message}};
  return out.dump(-1, ' ', true, json::error_handler_t::replace) + "\n";
}

}  // namespace tiltfeed::daemon
