// Requests to the desk, "METHOD|PATH|HOST|ORIGIN|SITE|TYPE|CSRF|LENGTH\n" and the body. What is refused, is
// refused by its head alone; what a body says of the machine is answered once, whatever it is.

#include <map>

#include "desk/api/run_api.h"
#include "desk/http/access_check.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::desk;

namespace {

std::string taken(std::string_view& rest, char separator) {
  const std::size_t end = rest.find(separator);
  const std::string field(rest.substr(0, end));
  rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
  return field;
}

Request request_of(std::string_view bytes) {
  Request request;
  std::string head = taken(bytes, '\n');
  std::string_view rest = head;
  for (std::string* field : {&request.method, &request.path, &request.host, &request.origin,
                             &request.fetch_site, &request.content_type, &request.csrf})
    *field = taken(rest, '|');
  request.cookie = request.csrf;
  request.accept_encoding = request.content_type;
  if (!rest.empty()) request.length = bytes.size();
  request.body = std::string(bytes);
  request.ticket = 1;
  return request;
}

void check_access(const Request& request) {
  const AccessRules rules{{"127.0.0.1:1"}, "http://", false};
  const bool change = request.method == "POST" || request.method == "PUT" || request.method == "DELETE";
  const auto stranger = refused(request, rules, {"", true}),
             owner = refused(request, rules, {"secret", true}),
             watcher = refused(request, rules, {"secret", false});
  HOLDS(request.host == "127.0.0.1:1" || (stranger && owner));
  const bool api = request.path.rfind("/api/", 0) == 0,
             enters = request.path == kSignIn && request.method == "POST";
  if (api && !enters) HOLDS(stranger);
  HOLDS(!owner || watcher);
  if (change && api && request.path != kSignIn) HOLDS(watcher);
  if (change && !owner) HOLDS(request.origin == "http://127.0.0.1:1" && (enters || request.csrf == "secret"));
  for (const auto& reply : {stranger, owner, watcher})
    HOLDS(!reply || (reply->status >= 400 && !reply->body.empty()));
  (void)cookie_value(request.cookie, "a");
  (void)accepts_gzip(request.accept_encoding);
}

}  // namespace

FUZZ_TARGET(desk) {
  const Request request = request_of(bytes);
  check_access(request);
  if (!RunApi::is_route(request.method, request.path)) return;
  std::map<std::uint64_t, int> finished;
  RunApi run({"/nonexistent/socket", "", "", "", ""},
             {[](const std::string&, const std::string&) {},
              [&](std::uint64_t ticket, const Reply& reply) {
                HOLDS(!reply.later && reply.status >= 200);
                ++finished[ticket];
              },
              [] { return std::optional<PlannedProgram>(); },
              [](std::uint64_t session) { return "browser " + std::to_string(session); }});
  Request asks;
  asks.method = "POST";
  asks.path = "/api/v1/seat/ask";
  HOLDS(run.answer(asks, 1).status == 200);
  const Reply reply = run.answer(request, 1);
  // Nobody listens there: what is answered later has been answered already.
  HOLDS(finished[1] == (reply.later ? 1 : 0));
  HOLDS(reply.later || (reply.status >= 200 && reply.status < 600));
  HOLDS(run.descriptors().empty());
}
