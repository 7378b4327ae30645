// The requests that cut the planned program on the simulated machine.

#include "desk/api/desk.h"
#include "desk/api/replies.h"

namespace tiltfeed::desk {

Reply Desk::start_cut(const Request&) {
  if (!plan_.is_planned()) return refusal(409, "there is no plan that is done; plan first");
  if (const Result<void> begun = cut_.start(plan_.cut_input()); !begun) return refused_by(begun.error());
  return text_reply(cut_.describe(), 202);
}

Reply Desk::cancel_cut(const Request&) {
  if (const Result<void> cancelled = cut_.cancel(); !cancelled) return refused_by(cancelled.error());
  return text_reply(cut_.describe(), 202);
}

Reply Desk::cut_view(const Request& request) { return cut_.view(request.operation); }

Reply Desk::cut_before(const Request& request) { return cut_.before(request.operation); }

Reply Desk::cut_page(const Request& request) { return cut_.page(request.operation); }

Reply Desk::cut_report(const Request& request) { return cut_.report(request.operation); }

}  // namespace tiltfeed::desk
