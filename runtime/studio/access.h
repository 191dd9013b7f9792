// Who may talk to a page's server: anybody who knows the token in the address that the program prints.
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

  Access();  // Draws a token of 128 random bits. Throws Error "no-random-numbers".

  void set_port(int port) { port_ = port; }
  // http://127.0.0.1:PORT/?token=TOKEN
  std::string address() const;
  // The Set-Cookie header that keeps the token in the browser.
  std::string cookie() const;

  // Refuses what names another host or comes from another site's page (so no page elsewhere can use the
  // server, nor any name that points here), what lacks the token in its address and in its cookies (so no
  // other account can), and bodies that are encoded or chunked (so their size is known before they are read).
  std::optional<Refusal> refusal(const httplib::Request&) const;

 private:
  bool is_ours(const std::string& host) const;
  bool is_from_our_page(const httplib::Request&) const;
  bool has_token(const httplib::Request&) const;
  std::string cookie_name() const;

  std::string token_;
  int port_ = 0;
};

}  // namespace terrazzo::studio
