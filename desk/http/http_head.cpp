#include "desk/http/http_head.h"

#include <microhttpd.h>

#include <charconv>

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

}  // namespace

Request head_of(MHD_Connection* connection, const char* url, const char* method) {
  Request request;
  request.method = method;
  request.path = url;
  request.host = header(connection, "Host");
  request.origin = header(connection, "Origin");
  request.fetch_site = header(connection, "Sec-Fetch-Site");
  request.content_type = header(connection, "Content-Type");
  request.cookie = header(connection, "Cookie");
  request.csrf = header(connection, "X-Tiltfeed-Csrf");
  request.accept_encoding = header(connection, "Accept-Encoding");
  request.if_none_match = header(connection, "If-None-Match");
  request.transfer_encoding = header(connection, "Transfer-Encoding");
  request.name = value(connection, MHD_GET_ARGUMENT_KIND, "name");
  request.unit = value(connection, MHD_GET_ARGUMENT_KIND, "unit");
  request.length = number(header(connection, "Content-Length"));
  request.last_event_id = number(header(connection, "Last-Event-ID"));
  return request;
}

}  // namespace tiltfeed::desk
