#include "desk/http/access_check.h"

#include <algorithm>

#include "desk/session/secret.h"

namespace tiltfeed::desk {
namespace {

bool is_change(const std::string& method) {
  return method == "POST" || method == "PUT" || method == "DELETE";
}

/// The media type without its parameters, lower case.
std::string media_type(const std::string& header) {
  std::string type = header.substr(0, header.find(';'));
  type.erase(std::remove(type.begin(), type.end(), ' '), type.end());
  std::transform(type.begin(), type.end(), type.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return type;
}

std::optional<Reply> refused_change(const Request& request, const AccessRules& rules, bool program) {
  const bool own = request.origin == rules.scheme + request.host;
  if (!own && !(program && request.origin.empty()))
    return refusal(403, "a change needs the header 'Origin: " + rules.scheme + request.host +
                            "'; pages of other sites may not send it");
  const bool has_body = request.length.value_or(0) > 0;
  const std::string type = media_type(request.content_type);
  if (has_body && type != kJson && type != kOctets)
    return refusal(415, std::string("the body must be ") + kJson + " or " + kOctets);
  if (request.method != "DELETE" && !request.length)
    return refusal(411, "a body needs its length: send Content-Length");
  return std::nullopt;
}

}  // namespace

std::optional<Reply> refused(const Request& request, const AccessRules& rules, const Sender& sender) {
  if (request.doubled) return refusal(400, "a header of this request stands twice");
  if (std::find(rules.hosts.begin(), rules.hosts.end(), request.host) == rules.hosts.end())
    return refusal(403, "this server is not known by the name that the header Host states");
  const bool change = is_change(request.method);
  if (!change && request.method != "GET" && request.method != "HEAD")
    return refusal(405, "expected GET, HEAD, POST, PUT or DELETE");
  if (!request.transfer_encoding.empty())
    return refusal(411, "a body needs its length: send Content-Length, not chunks");
  if (request.path.rfind(kApi, 0) != 0 && request.path != kMetrics) {
    if (change) return refusal(405, "only what is under /api/ takes changes");
    return std::nullopt;
  }
  const std::string& site = request.fetch_site;
  if (!site.empty() && site != "same-origin" && (change || site != "none"))
    return refusal(403, "another site's page may not ask this server");
  if (change)
    if (auto reply = refused_change(request, rules, sender.program)) return reply;
  if (sender.program) {
    if (request.path == kSignIn) return refusal(403, "a program with a token has no session");
    if (change && !sender.operates) return refusal(403, "this token is for watching only");
    return std::nullopt;
  }
  if (request.path == kSignIn && request.method == "POST") return std::nullopt;
  if (sender.csrf.empty())
    return refusal(401, rules.users ? "not signed in; sign in with name and password"
                                    : "not signed in; open the address that tiltfeed desk printed, or press "
                                      "Enter there for a new one");
  if (change && !same_secret(request.csrf, sender.csrf))
    return refusal(403,
                   "a change needs the header X-Tiltfeed-Csrf with the session's value; reload the page");
  if (change && !sender.operates && request.path != kSignIn)
    return refusal(403, "you are signed in to watch only");
  return std::nullopt;
}

}  // namespace tiltfeed::desk
