#include "config/webhook_keys.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>

namespace tiltfeed::config {
namespace {

constexpr std::size_t kMostWebhooks = 8;
constexpr std::size_t kLeastSecret = 16, kMostSecret = 1024;
constexpr std::string_view kHttp = "http://", kHttps = "https://";

bool is_visible(char letter) { return letter > ' ' && letter < 0x7F; }

bool is_host(std::string_view host) {
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  const std::string_view inside = bracketed ? host.substr(1, host.size() - 2) : host;
  return !inside.empty() && std::all_of(inside.begin(), inside.end(), [&](char c) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.';
    return plain || c == (bracketed ? ':' : '-');
  });
}

bool is_web_port(std::string_view text) {
  constexpr int kMost = 65535;
  int port = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), port);
  return read.ec == std::errc{} && read.ptr == text.data() + text.size() && port >= 1 && port <= kMost;
}

/// The file is its owner's alone. What root lets one other user read, as systemd does with credentials, is
/// his, too.
bool is_private(const struct stat& file) {
  constexpr mode_t kOthers = 077, kOthersOfRoot = 037;
  if (file.st_uid == 0 && ::geteuid() != 0) return (file.st_mode & kOthersOfRoot) == 0;
  return file.st_uid == ::geteuid() && (file.st_mode & kOthers) == 0;
}

Result<std::string> read_private(int fd, const std::string& path) {
  struct stat about {};
  if (fd < 0 || ::fstat(fd, &about) != 0) return fail(Code::kIo, path + ": " + std::strerror(errno));
  if (!S_ISREG(about.st_mode)) return fail(Code::kInput, path + ": is no regular file");
  if (!is_private(about))
    return fail(Code::kInput, path + ": belongs to another user, or others may read it; chmod 600 " + path);
  std::string text(kMostSecret + 3, '\0');
  const ssize_t got = ::read(fd, text.data(), text.size());
  if (got < 0) return fail(Code::kIo, path + ": " + std::strerror(errno));
  text.resize(static_cast<std::size_t>(got));
  return text;
}

}  // namespace

Result<std::string> read_secret_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  Result<std::string> text = read_private(fd, path);
  if (fd >= 0) ::close(fd);
  if (!text) return text;
  if (text->ends_with('\n')) text->pop_back();
  if (text->ends_with('\r')) text->pop_back();
  const bool good = text->size() >= kLeastSecret && text->size() <= kMostSecret &&
                    std::all_of(text->begin(), text->end(), is_visible);
  if (good) return text;
  return fail(Code::kInput,
              path + ": expected one line of " + std::to_string(kLeastSecret) + " to " +
                  std::to_string(kMostSecret) +
                  " visible ASCII characters without blanks; make one: (umask 077; openssl rand "
                  "-hex 32 > " +
                  path + ")");
}

Result<std::string> webhook_host(const std::string& url) {
  const bool secure = url.starts_with(kHttps);
  if (!secure && !url.starts_with(kHttp))
    return fail(Code::kInput, "expected a URL that begins with http:// or https://");
  if (!std::all_of(url.begin(), url.end(), is_visible) || url.find_first_of("#\\\"<>") != std::string::npos)
    return fail(Code::kInput,
                "a URL has no blanks, no fragment (#) and ASCII letters only; write others as %XX");
  const std::string_view rest = std::string_view(url).substr(secure ? kHttps.size() : kHttp.size());
  const std::string_view authority = rest.substr(0, rest.find_first_of("/?"));
  if (authority.find('@') != std::string_view::npos)
    return fail(Code::kInput, "a name or password in the URL is not sent; the signature proves who sends");
  const std::size_t colon = authority.find(':', authority.starts_with('[') ? authority.find(']') : 0);
  const bool has_port = colon != std::string_view::npos;
  if (!is_host(authority.substr(0, colon)) || (has_port && !is_web_port(authority.substr(colon + 1))))
    return fail(Code::kInput, "expected http://HOST/..., https://HOST:PORT/... with a port from 1 to 65535");
  return std::string(authority);
}

std::vector<Webhook> read_webhooks(const Section& root, const std::string& folder, bool secrets) {
  std::vector<Webhook> hooks;
  for (const Section& one : root.list("webhooks", {"url", "secret_file", "events"}, kMostWebhooks)) {
    Webhook hook;
    hook.url = one.text("url");
    if (one.sound("url")) {
      const Result<std::string> host = webhook_host(hook.url);
      if (!host) one.complain("url", host.error().message);
      hook.host = host.value_or("");
      if (std::any_of(hooks.begin(), hooks.end(),
                      [&](const Webhook& other) { return other.url == hook.url; }))
        one.complain("url", "is there twice");
    }
    hook.secret_file = (std::filesystem::path(folder) / one.text("secret_file")).lexically_normal().string();
    if (secrets && one.sound("secret_file")) {
      const Result<std::string> secret = read_secret_file(hook.secret_file);
      if (!secret) one.complain("secret_file", secret.error().message, secret.error().code);
      hook.secret = secret.value_or("");
    }
    const std::vector<std::string> events = one.lines("events", 2);
    for (const std::string& event : events)
      if (event != "done" && event != "fault")
        one.complain("events", "expected [done, fault] or one of them, found " + quoted(event));
    const auto has = [&](const char* word) {
      return events.empty() || std::find(events.begin(), events.end(), word) != events.end();
    };
    hook.done = has("done"), hook.fault = has("fault");
    hooks.push_back(std::move(hook));
  }
  return hooks;
}

}  // namespace tiltfeed::config
