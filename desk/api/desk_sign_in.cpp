// Who signs in, by the token of an address or by name and password, and out.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "desk/api/desk.h"
#include "desk/api/replies.h"
#include "desk/users/password_hash.h"
#include "desk/users/user_table.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

Reply json_reply(const json& value) {
  return text_reply(value.dump(-1, ' ', true, json::error_handler_t::replace));
}

}  // namespace

Reply Desk::sign_in(const Request& request) {
  if (rules_.users) return sign_in_by_password(request);
  const auto token = text_in(request.body, "token");
  if (!token) return refusal(400, "expected {\"token\": \"...\"}");
  const Result<std::optional<Session>> opened = sessions_.open(*token);
  if (!opened) return refusal(500, opened.error().message);
  if (!*opened)
    return refusal(401, "this address has been used; press Enter where tiltfeed desk runs for a new one");
  return signed_in(**opened);
}

/// The file is read each time: a user that was taken out is out.
Reply Desk::sign_in_by_password(const Request& request) {
  const auto name = text_in(request.body, "name"), password = text_in(request.body, "password");
  if (!name || !password) return refusal(400, "expected {\"name\": \"...\", \"password\": \"...\"}");
  const Result<std::vector<User>> users = load_users(options_.users);
  if (!users)  // who asks is not known yet: nothing of where files are
    return refusal(500, "the file of users cannot be used; tiltfeed desk user list says why");
  const auto found =
      std::find_if(users->begin(), users->end(), [&](const User& user) { return user.name == *name; });
  const bool known = found != users->end();
  const User user = known ? *found : User{*name, false, nobody_};
  const bool taken = passwords_.ask(
      *password, user.hash, known,
      [this, ticket = request.ticket, user](bool good) {
        if (!good) return finish_(ticket, refusal(401, "name or password are wrong"));
        const Result<Session> opened = sessions_.open_for(user.name, user.operates);
        finish_(ticket, opened ? signed_in(*opened) : refusal(500, opened.error().message));
      },
      std::chrono::steady_clock::now());
  if (!taken) return refusal(429, "too many have tried to sign in; wait a minute");
  Reply reply;
  reply.later = true;
  return reply;
}

Reply Desk::signed_in(const Session& session) const {
  Reply reply = json_reply({{"csrf", session.csrf}, {"session", session.number}});
  reply.headers.emplace_back("Set-Cookie", cookie_name() + "=" + session.cookie +
                                               "; HttpOnly; SameSite=Strict; Path=/" +
                                               (options_.https ? "; Secure" : ""));
  return reply;
}

Reply Desk::sign_out(const Request& request) {
  if (const Session* session = sessions_.find(cookie_of(request))) run_.sign_out(session->number);
  sessions_.close(cookie_of(request));
  return text_reply("{}");
}

Reply Desk::session(const Request& request) {
  const Session* session = sessions_.find(cookie_of(request));
  return json_reply({{"csrf", session->csrf},
                     {"session", session->number},
                     {"version", options_.version},
                     {"user", session->user},
                     {"operates", session->operates}});
}

}  // namespace tiltfeed::desk
