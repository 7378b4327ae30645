#include "desk/users/name_table.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kMostName = 32, kMostNames = 1000;

}  // namespace

bool is_user_name(const std::string& name) {
  return !name.empty() && name.size() <= kMostName && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

Result<std::vector<NameLine>> parse_names(const std::string& text, const std::string& path,
                                          const char* expected) {
  std::vector<NameLine> names;
  std::istringstream in(text);
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    NameLine found{{}, {}, {}, path + ":" + std::to_string(number) + ": "};
    const std::size_t first = line.find(':'),
                      second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) return found.wrong(std::string("expected ") + expected);
    found.name = line.substr(0, first), found.role = line.substr(first + 1, second - first - 1);
    found.secret = line.substr(second + 1);
    if (!is_user_name(found.name))
      return found.wrong("the name must be 1 to 32 of letters, digits, '.', '_' and '-'");
    if (std::any_of(names.begin(), names.end(),
                    [&](const NameLine& known) { return known.name == found.name; }))
      return found.wrong(found.name + " is there twice");
    if (names.size() >= kMostNames) return found.wrong("more than " + std::to_string(kMostNames) + " names");
    names.push_back(std::move(found));
  }
  return names;
}

Result<std::string> read_names(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) == 0 && (about.st_mode & S_IWOTH) != 0)
    return fail(Code::kInput, path + ": everybody may write it, and let themselves in; chmod o-w " + path);
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf() || in.peek() == std::ifstream::traits_type::eof()))
    return fail(Code::kIo, path + ": cannot be read");
  return text.str();
}

Result<void> save_names(const std::string& path, const std::string& text) {
  constexpr mode_t kMode = 0640;
  const std::string fresh = path + ".new";
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
