#pragma once
// What fills the words of a dialect's table, of a whole program and of one tool.

#include "daemon/post/dialect.h"
#include "daemon/post/posting.h"

namespace tiltfeed::daemon {

/// Of the whole program; {register}, {edge} and {tool} stand at its end, for no tool.
Filling filling_of(const Posting& posting);
/// The same with the operation's tool.
void fill_tool(Filling& filling, const Operation& op);

}  // namespace tiltfeed::daemon
