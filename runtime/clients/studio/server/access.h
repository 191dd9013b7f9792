// Access control of a page: only clients that know the token in the printed address may use it.
#pragma once

#include <optional>
#include <string>

#include "graph/diagnostic.h"

namespace httplib {
struct Request;
}

namespace terrazzo::studio {

class Access {
 public:
  struct Refusal {
    int status;
    Diagnostic why;
  };

  // Creates a token of 128 random bits. `command` names the cookie, and the command in messages: "paint".
  // Throws Error "no-random-numbers".
  explicit Access(std::string command);

  void set_port(int port) { port_ = port; }
  // http://127.0.0.1:PORT/?token=TOKEN
  std::string address() const;
  // The Set-Cookie header value that stores the token in the browser.
  std::string cookie() const;

  // Refuses requests that name another host or come from another site's page, to block cross-site requests
  // and DNS rebinding. Only the page itself may be opened from elsewhere. Any port of this machine's names
  // is accepted, so that a forwarded port works (ssh -L). Refuses requests without the token in their address
  // or cookies, to block other accounts on this machine. Refuses encoded or chunked bodies, so that a body's
  // size is known before it is read.
  std::optional<Refusal> refusal(const httplib::Request&) const;

 private:
  static bool is_from_our_page(const httplib::Request&);
  bool has_token(const httplib::Request&) const;
  std::string cookie_name() const;

  std::string command_, token_;
  int port_ = 0;
};

}  // namespace terrazzo::studio
