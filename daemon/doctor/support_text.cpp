#include "daemon/doctor/support_text.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

constexpr const char* kMask = "***";
constexpr std::string_view kSecretWords[] = {"password", "passphrase",    "passcode",   "passwd", "pwd",
                                             "secret",   "token",         "credential", "apikey", "_key",
                                             "-key",     "authorization", "cookie",     "csrf",   "pass"};
/// Passes are what a path is made of: this one is a secret only as a key of its own, behind one of these.
constexpr std::string_view kPassAlone = "pass", kBeforeKeys = "{,#-&?;";
/// Before a secret without a sign between, as in the head of an HTTP request.
constexpr std::string_view kBearer = "bearer ";
constexpr std::string_view kEndsOfAddress = " \t\"'<>)";
/// A key of TLS or SSH between these.
constexpr std::string_view kKeyBegins = "-----BEGIN ", kIsPrivate = "PRIVATE KEY", kKeyEnds = "-----END ";

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Where the value of a secret begins; npos: the line has none.
std::size_t secret_value(std::string_view line) {
  std::string small(line);
  std::transform(small.begin(), small.end(), small.begin(), lower);
  const std::size_t bearer = small.find(kBearer);
  std::size_t first = bearer == small.npos ? small.npos : bearer + kBearer.size();
  for (const std::string_view word : kSecretWords)
    for (std::size_t at = 0; (at = small.find(word, at)) != small.npos;) {
      const std::size_t dashes = small.find_last_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-", at);
      const std::size_t option = dashes == small.npos ? 0 : dashes + 1;
      const std::size_t before = at == 0 ? small.npos : small.find_last_not_of(" \t\"'", at - 1);
      const bool alone = before == small.npos || kBeforeKeys.find(small[before]) != kBeforeKeys.npos;
      at += word.size();
      if (word == kPassAlone && !alone) continue;
      if (small.substr(at, 1) == "s") ++at;
      const std::size_t sign = small.find_first_not_of("\"' \t", at);
      if (sign == small.npos) break;
      if (small[sign] == ':' || small[sign] == '=') first = std::min(first, sign + 1);
      // --password VALUE
      if (small.substr(option, 2) == "--" && sign > at) first = std::min(first, sign);
    }
  return first;
}

/// Where a private key begins; npos: none does.
std::size_t private_key(std::string_view line) {
  const std::size_t at = line.find(kKeyBegins);
  return at != line.npos && line.find(kIsPrivate, at) != line.npos ? at : line.npos;
}

/// The value is not on the line of its key, but on those below that are further in (YAML).
bool stands_below(std::string_view value) {
  const std::size_t begin = value.find_first_not_of(" \t\r");
  return begin == value.npos || value[begin] == '|' || value[begin] == '>';
}

/// Of a database's address that states user and password: up to where the password may go, as one with a
/// slash, a question mark or, in quotes, a blank is written by mistake. Else `host_end`.
std::size_t longest_user(std::string_view line, std::size_t at, std::size_t host_end) {
  const std::string_view scheme = line.substr(0, at);
  if (!scheme.ends_with("postgres://") && !scheme.ends_with("postgresql://")) return host_end;
  const std::size_t before = line.rfind("postgres", at);
  const bool quoted = before > 0 && (line[before - 1] == '"' || line[before - 1] == '\'');
  const std::size_t end = std::min(
      quoted ? line.find(line[before - 1], at) : line.find_first_of(kEndsOfAddress, at), line.size());
  const std::size_t colon = line.find(':', at), sign = line.substr(0, end).rfind('@');
  return sign != line.npos && colon < sign ? end : host_end;
}

/// Addresses in a line.
std::string masked_addresses(std::string line) {
  for (std::size_t at = 0; (at = line.find("://", at)) != line.npos;) {
    const bool http = line.substr(0, at).ends_with("http") || line.substr(0, at).ends_with("https");
    at += 3;
    std::size_t end = std::min(line.find_first_of(kEndsOfAddress, at), line.size());
    const std::size_t host_end = longest_user(line, at, std::min(line.find_first_of("/?#", at), end));
    if (const std::size_t sign = line.rfind('@', host_end);
        sign != line.npos && sign >= at && sign < host_end) {
      line.replace(at, sign - at, kMask);
      end = std::min(line.find_first_of(kEndsOfAddress, at), line.size());
    }
    const std::size_t fragment = line.find('#', at);
    if (http && fragment != line.npos && fragment < end)
      line.replace(fragment + 1, end - fragment - 1, kMask);
  }
  return line;
}

}  // namespace

std::string without_secrets(std::string_view text) {
  std::string out;
  std::size_t secret_in = text.npos;  // what is further in than this belongs to a secret; npos: nothing
  bool in_key = false;                // in the lines of a private key
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    const std::size_t in = std::min(line.find_first_not_of(" \t\r"), line.size());
    if (in < line.size() && in <= secret_in) secret_in = text.npos;
    if (const bool ends = in_key && line.find(kKeyEnds) != line.npos; in_key) {
      line = line.substr(0, in) + (in < line.size() ? kMask : "");
      in_key = !ends;
    } else if (const std::size_t begin = private_key(line); begin != line.npos) {
      in_key = line.find(kKeyEnds, begin) == line.npos;
      line = line.substr(0, begin) + kMask;
    } else if (secret_in != text.npos && in < line.size()) {
      line = line.substr(0, in) + kMask;
    } else if (const std::size_t value = secret_value(line); value != line.npos) {
      if (stands_below(std::string_view(line).substr(value))) secret_in = in;
      line = line.substr(0, value) + " " + kMask;
    }
    out += masked_addresses(std::move(line));
    if (end < text.size()) out += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

std::string support_section(const std::string& title, const std::string& text) {
  std::string out = "==== " + title + " ====\n" + without_secrets(valid_text(text));
  if (!out.ends_with('\n')) out += '\n';
  return out + '\n';
}

std::string tail_of_file(const std::string& path, std::size_t most) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return "cannot be read: " + std::string(std::strerror(errno));
  const auto size = static_cast<std::size_t>(std::max<std::streamoff>(in.tellg(), 0));
  const std::size_t from = size > most ? size - most : 0;
  in.seekg(static_cast<std::streamoff>(from));
  std::string text(size - from, 0);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  if (from > 0) text.erase(0, std::min(text.find('\n'), text.size() - 1) + 1);
  return text;
}

}  // namespace tiltfeed::daemon
