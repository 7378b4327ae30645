#pragma once
// A request as the server hands it on, and what it gets back.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tiltfeed::desk {

/// Header fields that are absent are empty.
struct Request {
  std::string method, path;  ///< the path without its query, as sent: nothing in it is decoded
  std::string host, origin, fetch_site, content_type, cookie, csrf, authorization, accept_encoding,
      if_none_match;
  std::string transfer_encoding;
  bool doubled = false;                        ///< a header that counts here stands twice
  std::string name, unit, operation;           ///< of the query, where it has them
  std::optional<std::uint64_t> length;         ///< Content-Length, where it is a number
  std::optional<std::uint64_t> last_event_id;  ///< where it is a number
  std::string body;                            ///< of a text body
  std::string file;          ///< of a file body: where it was put; the taker renames it away
  std::uint64_t ticket = 0;  ///< by which a reply that comes later finds it
};

struct Reply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::string_view bytes;  ///< instead of `body`: bytes that live as long as the program
  std::string file;        ///< instead of `body`: a file whose bytes are sent
  std::vector<std::pair<std::string, std::string>> headers;
  bool events = false;  ///< instead of `body`: the stream of events, for as long as the client listens
  std::optional<std::uint64_t> events_after = {};  ///< of `events`: the last that the listener has had
  bool later = false;                              ///< there is no reply yet: HttpServer::finish() brings it
};

/// {"error": message}.
Reply refusal(int status, const std::string& message);

/// How much of a body a request may have, and where it goes.
struct BodyRule {
  std::uint64_t most = 0;
  bool file = false;
};

/// The value of a cookie in a Cookie header; empty where it is not there.
std::string_view cookie_value(std::string_view header, std::string_view name);
/// A gzip coding is among those of an Accept-Encoding header, and not with q=0.
bool accepts_gzip(std::string_view header);

}  // namespace tiltfeed::desk
