#include "desk/command/token_command.h"

#include <algorithm>
#include <filesystem>

#include "desk/session/secret.h"
#include "desk/users/name_table.h"
#include "desk/users/token_table.h"

namespace tiltfeed::desk {

Result<std::string> add_token(const std::string& file, const std::string& name, const std::string& scope) {
  if (!is_user_name(name))
    return fail(Code::kUsage, "the name '" + name + "' must be 1 to 32 of letters, digits, '.', '_' and '-'");
  Result<std::vector<ProgramToken>> tokens = std::vector<ProgramToken>{};
  if (std::filesystem::exists(file)) tokens = load_tokens(file);
  if (!tokens) return tl::unexpected<Error>(tokens.error());
  Result<std::string> token = random_secret();
  if (!token) return token;
  std::erase_if(*tokens, [&](const ProgramToken& known) { return known.name == name; });
  tokens->push_back({name, scope == "submit", digest_of(*token)});
  if (const Result<void> saved = save_tokens(file, *tokens); !saved) return tl::unexpected(saved.error());
  return token;
}

Result<void> remove_token(const std::string& file, const std::string& name) {
  Result<std::vector<ProgramToken>> tokens = load_tokens(file);
  if (!tokens) return tl::unexpected<Error>(tokens.error());
  if (std::erase_if(*tokens, [&](const ProgramToken& known) { return known.name == name; }) == 0)
    return fail(Code::kUsage, file + ": there is no token of " + name);
  return save_tokens(file, *tokens);
}

Result<std::string> list_tokens(const std::string& file) {
  const Result<std::vector<ProgramToken>> tokens = load_tokens(file);
  if (!tokens) return tl::unexpected<Error>(tokens.error());
  std::string text;
  for (const ProgramToken& token : *tokens) text += token.name + (token.submits ? " submit\n" : " watch\n");
  return text;
}

}  // namespace tiltfeed::desk
