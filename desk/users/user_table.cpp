#include "desk/users/user_table.h"

#include <algorithm>

namespace tiltfeed::desk {
namespace {

bool is_hash(const std::string& text) {
  return text.rfind("$y$", 0) == 0 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
                  c == '/' || c == '$';
         });
}

}  // namespace

Result<std::vector<User>> parse_users(const std::string& text, const std::string& path) {
  const Result<std::vector<NameLine>> lines = parse_names(text, path, "NAME:ROLE:HASH");
  if (!lines) return tl::unexpected<Error>(lines.error());
  std::vector<User> users;
  for (const NameLine& line : *lines) {
    if (line.role != "watch" && line.role != "operate")
      return line.wrong("the role '" + line.role + "' must be watch or operate");
    if (!is_hash(line.secret)) return line.wrong("the hash is no yescrypt hash; use tiltfeed desk user add");
    users.push_back({line.name, line.role == "operate", line.secret});
  }
  return users;
}

std::string write_users(const std::vector<User>& users) {
  std::string text;
  for (const User& user : users)
    text += user.name + (user.operates ? ":operate:" : ":watch:") + user.hash + "\n";
  return text;
}

Result<std::vector<User>> load_users(const std::string& path) {
  const Result<std::string> text = read_names(path);
  if (!text) return tl::unexpected<Error>(text.error());
  return parse_users(*text, path);
}

Result<void> save_users(const std::string& path, const std::vector<User>& users) {
  return save_names(path, write_users(users));
}

}  // namespace tiltfeed::desk
