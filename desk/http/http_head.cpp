#include "desk/http/http_head.h"

#include <microhttpd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>

namespace tiltfeed::desk {
namespace {

std::string value(MHD_Connection* connection, MHD_ValueKind kind, const char* name) {
  const char* text = MHD_lookup_connection_value(connection, kind, name);
  return text ? text : "";
}

std::string header(MHD_Connection* connection, const char* name) {
  return value(connection, MHD_HEADER_KIND, name);
}

std::optional<std::uint64_t> number(const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

constexpr std::array<const char*, 9> kOnce{"Host",           "Origin", "Sec-Fetch-Site",  "Content-Type",
                                           "Content-Length", "Cookie", "X-Tiltfeed-Csrf", "Transfer-Encoding",
                                           "Authorization"};
using Counts = std::array<int, kOnce.size()>;

MHD_Result count_header(void* counts, MHD_ValueKind, const char* name, const char*) {
  for (std::size_t i = 0; i < kOnce.size(); ++i)
    if (strcasecmp(name, kOnce[i]) == 0) ++(*static_cast<Counts*>(counts))[i];
  return MHD_YES;
}

/// Whoever reads the first and whoever reads the last would not agree.
bool has_doubled(MHD_Connection* connection) {
  Counts counts{};
  MHD_get_connection_values(connection, MHD_HEADER_KIND, count_header, &counts);
  return std::any_of(counts.begin(), counts.end(), [](int count) { return count > 1; });
}

}  // namespace

Request head_of(MHD_Connection* connection, const char* url, const char* method) {
  Request request;
  request.method = method;
  request.doubled = has_doubled(connection);
  request.path = url;
  request.host = header(connection, "Host");
  request.origin = header(connection, "Origin");
  request.fetch_site = header(connection, "Sec-Fetch-Site");
  request.content_type = header(connection, "Content-Type");
  request.cookie = header(connection, "Cookie");
  request.csrf = header(connection, "X-Tiltfeed-Csrf");
  request.authorization = header(connection, "Authorization");
  request.accept_encoding = header(connection, "Accept-Encoding");
  request.if_none_match = header(connection, "If-None-Match");
  request.transfer_encoding = header(connection, "Transfer-Encoding");
  request.name = value(connection, MHD_GET_ARGUMENT_KIND, "name");
  request.unit = value(connection, MHD_GET_ARGUMENT_KIND, "unit");
  request.operation = value(connection, MHD_GET_ARGUMENT_KIND, "operation");
  request.length = number(header(connection, "Content-Length"));
  request.last_event_id = number(header(connection, "Last-Event-ID"));
  return request;
}

}  // namespace tiltfeed::desk
