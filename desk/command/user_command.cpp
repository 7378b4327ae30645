#include "desk/command/user_command.h"

#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "desk/users/password_hash.h"
#include "desk/users/user_table.h"

namespace tiltfeed::desk {
namespace {

/// While it lives, the terminal shows nothing that is typed.
struct Silence {
  termios before{};
  bool on = ::tcgetattr(STDIN_FILENO, &before) == 0;
  Silence() {
    termios quiet = before;
    quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    on = on && ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &quiet) == 0;
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;
  ~Silence() {
    if (on) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before);
  }
};

Result<std::string> typed(const char* question) {
  std::string line;
  std::cerr << question << std::flush;
  const bool read = static_cast<bool>(std::getline(std::cin, line));
  std::cerr << "\n";
  if (!read) return fail(Code::kCancelled, "no password was typed; nothing was changed");
  return line;
}

Result<std::string> asked_password() {
  if (::isatty(STDIN_FILENO) != 1) {
    std::string line;
    if (!std::getline(std::cin, line)) return fail(Code::kUsage, "expected the password on standard input");
    return line;
  }
  const Silence silence;
  if (!silence.on) return fail(Code::kIo, "the terminal's echo cannot be switched off");
  const Result<std::string> first = typed("Password: ");
  if (!first) return first;
  const Result<std::string> again = typed("The same again: ");
  if (!again) return again;
  if (*first != *again) return fail(Code::kUsage, "the two passwords differ; nothing was changed");
  return first;
}

Result<std::vector<User>> users_in(const std::string& file) {
  if (!std::filesystem::exists(file)) return std::vector<User>{};
  return load_users(file);
}

}  // namespace

Result<void> add_user(const std::string& file, const std::string& name, const std::string& role) {
  if (!is_user_name(name))
    return fail(Code::kUsage, "the name '" + name + "' must be 1 to 32 of letters, digits, '.', '_' and '-'");
  Result<std::vector<User>> users = users_in(file);
  if (!users) return tl::unexpected<Error>(users.error());
  const Result<std::string> password = asked_password();
  if (!password) return tl::unexpected<Error>(password.error());
  const Result<std::string> hash = hash_password(*password);
  if (!hash) return tl::unexpected<Error>(hash.error());
  std::erase_if(*users, [&](const User& user) { return user.name == name; });
  users->push_back({name, role == "operate", *hash});
  return save_users(file, *users);
}

Result<void> remove_user(const std::string& file, const std::string& name) {
  Result<std::vector<User>> users = load_users(file);
  if (!users) return tl::unexpected<Error>(users.error());
  if (std::erase_if(*users, [&](const User& user) { return user.name == name; }) == 0)
    return fail(Code::kUsage, file + ": there is no user " + name);
  return save_users(file, *users);
}

Result<std::string> list_users(const std::string& file) {
  const Result<std::vector<User>> users = load_users(file);
  if (!users) return tl::unexpected<Error>(users.error());
  std::string text;
  for (const User& user : *users) text += user.name + (user.operates ? " operate\n" : " watch\n");
  return text;
}

}  // namespace tiltfeed::desk
