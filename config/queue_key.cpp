#include "config/queue_key.h"

#include <algorithm>
#include <string_view>

namespace tiltfeed::config {
namespace {

constexpr std::string_view kSchemes[] = {"postgresql://", "postgres://"};
constexpr int kMostAhead = 100;
constexpr std::size_t kLongestUrl = 1000;
constexpr std::string_view kMask = "***";

std::size_t scheme_of(std::string_view url) {
  for (const std::string_view scheme : kSchemes)
    if (url.starts_with(scheme)) return scheme.size();
  return 0;
}

/// "HOST:PORT", several with commas, without a user: is a port something else than a number?
bool has_odd_port(std::string_view hosts) {
  bool in_port = false;
  for (const char c : hosts) {
    if (in_port && c != ',' && (c < '0' || c > '9')) return true;
    in_port = c == ':' || (in_port && c != ',');
  }
  return false;
}

/// A password with a slash in it looks like HOST:PORT/DATABASE: where one may end, and npos where none does.
std::size_t end_of_slashed(std::string_view url, std::size_t colon, std::size_t slash) {
  const std::size_t sign = url.rfind('@');
  if (sign == url.npos || sign < slash) return url.npos;
  const bool in_path = url.substr(slash, url.find('?', slash) - slash).find('@') != url.npos;
  return in_path || has_odd_port(url.substr(colon, slash - colon)) ? sign : url.npos;
}

/// Where the user's password begins, and its length; {0, 0}: there is none.
std::pair<std::size_t, std::size_t> password_of(std::string_view url) {
  const std::size_t begin = scheme_of(url), end = std::min(url.find('/', begin), url.size());
  if (begin == 0) return {0, 0};
  std::size_t sign = url.substr(0, end).rfind('@'), from = begin;
  const bool has_user = sign != url.npos && sign >= begin;
  // The colons in [IPv6] are no port's.
  if (const std::size_t bracket = url.substr(0, end).rfind(']'); !has_user && bracket != url.npos)
    from = bracket;
  const std::size_t colon = url.substr(0, end).find(':', from);
  if (colon == url.npos) return {0, 0};
  if (!has_user) sign = end_of_slashed(url, colon, end);
  if (sign == url.npos || colon > sign) return {0, 0};
  return {colon + 1, sign - colon - 1};
}

/// The value of a parameter whose name ends in "password", likewise.
std::pair<std::size_t, std::size_t> password_parameter(std::string_view url, std::size_t from) {
  constexpr std::string_view kName = "password=";
  const std::size_t at = url.find(kName, from);
  if (at == url.npos) return {0, 0};
  const std::size_t begin = at + kName.size();
  return {begin, std::min(url.find('&', begin), url.size()) - begin};
}

/// libpq decodes names, too; all of its names are letters, so one with a % has something to hide.
bool has_coded_name(std::string_view url) {
  for (std::size_t at = url.find('?'); at != url.npos; at = url.find('&', at + 1)) {
    const std::string_view name = url.substr(at + 1, url.find_first_of("=&", at + 1) - at - 1);
    if (name.find('%') != name.npos) return true;
  }
  return false;
}

}  // namespace

Result<void> check_queue_url(const std::string& url) {
  if (scheme_of(url) == 0)
    return fail(Code::kInput,
                "expected postgresql://USER@HOST/DATABASE, or \"\" for the service's own spool alone");
  const bool visible = std::all_of(url.begin(), url.end(), [](char c) { return c > ' ' && c < 0x7F; });
  if (!visible || url.size() > kLongestUrl)
    return fail(Code::kInput, "expected visible ASCII without blanks, at most " +
                                  std::to_string(kLongestUrl) + " bytes; write other characters as %XX");
  if (password_of(url).first > 0 || password_parameter(url, 0).first > 0)
    return fail(Code::kInput,
                "no password stands here, where others may read it: leave it out and put it into a file of "
                "mode 0600, as HOST:PORT:DATABASE:USER:PASSWORD, and add ?passfile=FILE");
  if (has_coded_name(url))
    return fail(Code::kInput, "the name of a parameter has %XX in it: write it with letters, as ?sslmode=");
  return {};
}

std::string shown_queue(const std::string& url) {
  std::string shown = url;
  if (has_coded_name(shown)) shown.replace(shown.find('?'), shown.npos, kMask);
  if (const auto [at, size] = password_of(shown); at > 0) shown.replace(at, size, kMask);
  for (auto [at, size] = password_parameter(shown, 0); at > 0;) {
    shown.replace(at, size, kMask);
    std::tie(at, size) = password_parameter(shown, at);
  }
  return shown;
}

QueueChoice read_queue(const Section& root) {
  QueueChoice queue;
  queue.url = root.text("queue", "");
  queue.ahead = root.integer("queue_ahead", 1, kMostAhead, 1);
  queue.plans = root.flag("plan_for_others", queue.plans);
  if (queue.url.empty() || !root.sound("queue")) return queue;
  if (const Result<void> good = check_queue_url(queue.url); !good)
    root.complain("queue", good.error().message);
  return queue;
}

}  // namespace tiltfeed::config
