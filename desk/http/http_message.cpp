#include "desk/http/http_message.h"

#include <nlohmann/json.hpp>

namespace tiltfeed::desk {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// The text before the separator, which goes from `rest` with it.
std::string_view take_until(std::string_view& rest, char separator) {
  const std::size_t end = rest.find(separator);
  const std::string_view taken = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
  return trimmed(taken);
}

}  // namespace

Reply refusal(int status, const std::string& message) {
  Reply reply;
  reply.status = status;
  reply.body =
      nlohmann::json{{"error", message}}.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
  return reply;
}

std::string_view cookie_value(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    std::string_view pair = take_until(header, ';');
    const std::string_view key = take_until(pair, '=');
    if (key == name) return trimmed(pair);
  }
  return {};
}

bool accepts_gzip(std::string_view header) {
  while (!header.empty()) {
    std::string_view item = take_until(header, ',');
    const std::string_view coding = take_until(item, ';');
    if (coding != "gzip" && coding != "*") continue;
    const std::string_view weight = trimmed(item);
    return weight != "q=0" && weight.substr(0, 4) != "q=0."
               ? true
               : weight.find_first_of("123456789") != std::string_view::npos;
  }
  return false;
}

}  // namespace tiltfeed::desk
