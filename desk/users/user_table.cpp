#include "desk/users/user_table.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kMostName = 32, kMostUsers = 1000;

bool is_hash(const std::string& text) {
  return text.rfind("$y$", 0) == 0 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
                  c == '/' || c == '$';
         });
}

}  // namespace

bool is_user_name(const std::string& name) {
  return !name.empty() && name.size() <= kMostName && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

Result<std::vector<User>> parse_users(const std::string& text, const std::string& path) {
  std::vector<User> users;
  std::istringstream in(text);
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    const auto wrong = [&](const std::string& what) {
      return fail(Code::kInput, path + ":" + std::to_string(number) + ": " + what);
    };
    const std::size_t first = line.find(':'),
                      second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) return wrong("expected NAME:ROLE:HASH");
    const std::string name = line.substr(0, first), role = line.substr(first + 1, second - first - 1);
    if (!is_user_name(name)) return wrong("the name must be 1 to 32 of letters, digits, '.', '_' and '-'");
    if (role != "watch" && role != "operate")
      return wrong("the role '" + role + "' must be watch or operate");
    if (!is_hash(line.substr(second + 1)))
      return wrong("the hash is no yescrypt hash; use tiltfeed desk user add");
    if (std::any_of(users.begin(), users.end(), [&](const User& user) { return user.name == name; }))
      return wrong(name + " is there twice");
    if (users.size() >= kMostUsers) return wrong("more than " + std::to_string(kMostUsers) + " users");
    users.push_back({name, role == "operate", line.substr(second + 1)});
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
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf() || in.peek() == std::ifstream::traits_type::eof()))
    return fail(Code::kIo, path + ": cannot be read");
  return parse_users(text.str(), path);
}

Result<void> save_users(const std::string& path, const std::vector<User>& users) {
  constexpr mode_t kMode = 0640;
  const std::string text = write_users(users), fresh = path + ".new";
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, kMode);
  bool good = fd >= 0 && ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
              ::fsync(fd) == 0;
  good = good && ::rename(fresh.c_str(), path.c_str()) == 0;
  const int why = errno;
  if (fd >= 0) ::close(fd);
  if (good) return {};
  if (fd >= 0) ::unlink(fresh.c_str());
  return fail(Code::kIo, (fd < 0 ? fresh : path) + ": " + std::strerror(why));
}

}  // namespace tiltfeed::desk
