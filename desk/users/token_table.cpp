#include "desk/users/token_table.h"

#include <gcrypt.h>

#include <algorithm>
#include <array>

#include "desk/session/secret.h"
#include "desk/users/name_table.h"

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kDigits = 64;

bool is_digest(const std::string& text) {
  return text.size() == kDigits && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

std::string digest_of(const std::string& token) {
  [[maybe_unused]] static const char* const ready = gcry_check_version(nullptr);  // before any use of it
  std::array<unsigned char, kDigits / 2> digest{};
  gcry_md_hash_buffer(GCRY_MD_SHA256, digest.data(), token.data(), token.size());
  std::string text;
  for (const unsigned char byte : digest) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

Result<std::vector<ProgramToken>> parse_tokens(const std::string& text, const std::string& path) {
  const Result<std::vector<NameLine>> lines = parse_names(text, path, "NAME:SCOPE:DIGEST");
  if (!lines) return tl::unexpected<Error>(lines.error());
  std::vector<ProgramToken> tokens;
  for (const NameLine& line : *lines) {
    if (line.role != "watch" && line.role != "submit")
      return line.wrong("the scope '" + line.role + "' must be watch or submit");
    if (!is_digest(line.secret)) return line.wrong("the digest is none; use tiltfeed desk token add");
    tokens.push_back({line.name, line.role == "submit", line.secret});
  }
  return tokens;
}

std::string write_tokens(const std::vector<ProgramToken>& tokens) {
  std::string text;
  for (const ProgramToken& token : tokens)
    text += token.name + (token.submits ? ":submit:" : ":watch:") + token.digest + "\n";
  return text;
}

Result<std::vector<ProgramToken>> load_tokens(const std::string& path) {
  const Result<std::string> text = read_names(path);
  if (!text) return tl::unexpected<Error>(text.error());
  return parse_tokens(*text, path);
}

Result<void> save_tokens(const std::string& path, const std::vector<ProgramToken>& tokens) {
  return save_names(path, write_tokens(tokens));
}

std::optional<ProgramToken> find_token(const std::vector<ProgramToken>& tokens, const std::string& token) {
  const std::string digest = digest_of(token);
  const auto found = std::find_if(tokens.begin(), tokens.end(), [&](const ProgramToken& known) {
    return same_secret(known.digest, digest);
  });
  return found == tokens.end() ? std::nullopt : std::optional(*found);
}

}  // namespace tiltfeed::desk
