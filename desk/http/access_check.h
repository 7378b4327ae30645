#pragma once
// Who may ask what: the checks that every request passes before its body is read.

#include <optional>
#include <string>
#include <vector>

#include "desk/http/http_message.h"

namespace tiltfeed::desk {

struct AccessRules {
  std::vector<std::string> hosts;  ///< host:port, as this server is named in addresses
  std::string scheme = "http://";
  bool users = false;  ///< one signs in by name and password
};

/// What is known of the sender: the secret that its changes have to state; empty: not signed in.
struct Sender {
  std::string csrf;
  bool operates = true;  ///< else only watches: every change but signing out is refused
  bool program = false;  ///< known by a token in the header Authorization, without a session
};

inline constexpr char kApi[] = "/api/";
/// Where Prometheus looks; it needs a token as the API does.
inline constexpr char kMetrics[] = "/metrics";
inline constexpr char kSignIn[] = "/api/v1/session";
inline constexpr char kJson[] = "application/json", kOctets[] = "application/octet-stream";

/// Nothing where the request may go on. Properties:
/// 1 A Host that is not on the list is refused, whatever is asked: a name that was rebound to this address
///   reaches nothing.
/// 2 The API is refused to another site's page by Sec-Fetch-Site where the browser sends it; a change
///   (POST, PUT, DELETE) also where Origin is not this server, or where the body has a type that a form
///   can send.
/// 3 The API but for signing in is refused without a session, a change without the session's CSRF secret.
/// 4 A header that counts and stands twice is refused: 400.
/// 5 A body without a length is refused: 411.
/// 6 A program needs neither Origin nor CSRF secret: no browser adds its header by itself, and what another
///   site's page sends is refused by 2. It has no session, and may not sign in.
std::optional<Reply> refused(const Request& request, const AccessRules& rules, const Sender& sender);

}  // namespace tiltfeed::desk
