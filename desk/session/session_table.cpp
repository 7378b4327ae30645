#include "desk/session/session_table.h"

#include <algorithm>

#include "desk/session/secret.h"

namespace tiltfeed::desk {

Result<std::string> SessionTable::new_token() {
  Result<std::string> token = random_secret();
  if (token) token_ = *token;
  return token;
}

Result<std::optional<Session>> SessionTable::open(const std::string& token) {
  if (token_.empty() || !same_secret(token, token_)) return std::optional<Session>{};
  Result<Session> opened = open_for("", true);
  if (!opened) return tl::unexpected<Error>(opened.error());
  token_.clear();
  return std::optional<Session>(std::move(*opened));
}

Result<Session> SessionTable::open_for(const std::string& user, bool operates) {
  Result<std::string> cookie = random_secret(), csrf = random_secret();
  if (!cookie) return tl::unexpected<Error>(cookie.error());
  if (!csrf) return tl::unexpected<Error>(csrf.error());
  const auto older = [](const Session& a, const Session& b) { return a.seen < b.seen; };
  if (sessions_.size() >= kSessions)
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(), older));
  sessions_.push_back({++last_, *cookie, *csrf, std::chrono::steady_clock::now(), user, operates});
  return sessions_.back();
}

const Session* SessionTable::number(std::uint64_t number) const {
  for (const Session& session : sessions_)
    if (session.number == number) return &session;
  return nullptr;
}

const Session* SessionTable::find(const std::string& cookie) {
  Session* found = nullptr;
  for (Session& session : sessions_)
    if (same_secret(session.cookie, cookie)) found = &session;
  if (found) found->seen = std::chrono::steady_clock::now();
  return found;
}

void SessionTable::close(const std::string& cookie) {
  std::erase_if(sessions_, [&](const Session& session) { return same_secret(session.cookie, cookie); });
}

}  // namespace tiltfeed::desk
