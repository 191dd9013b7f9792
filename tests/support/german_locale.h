// A program whose locale writes decimal commas, as a host of the Python module may be.
#pragma once

#include <clocale>
#include <locale>
#include <string>

namespace terrazzo::test {

// While it exists, streams read decimal commas and dots between thousands; so do the functions of the C
// library if the system has the locale de_DE.
class GermanLocale {
 public:
  GermanLocale()
      : c_locale_(std::setlocale(LC_ALL, nullptr)),
        before_(std::locale::global(std::locale(std::locale::classic(), new DecimalComma))) {
    std::setlocale(LC_ALL, "de_DE.UTF-8");
  }
  ~GermanLocale() {
    std::locale::global(before_);
    std::setlocale(LC_ALL, c_locale_.c_str());
  }
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;

 private:
  struct DecimalComma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::string c_locale_;
  std::locale before_;
};

}  // namespace terrazzo::test
