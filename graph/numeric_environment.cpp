#include "graph/numeric_environment.h"

namespace terrazzo {
namespace {

// Never freed, since threads may use it until the process ends.
locale_t plain_locale() {
  static const locale_t c = ::newlocale(LC_ALL_MASK, "C", nullptr);
  return c;
}

}  // namespace

NumericEnvironment::NumericEnvironment() {
  std::fegetenv(&floating_point_);
  std::fesetenv(FE_DFL_ENV);
  locale_ = ::uselocale(plain_locale());
}

NumericEnvironment::~NumericEnvironment() {
  ::uselocale(locale_);
  std::fesetenv(&floating_point_);
}

}  // namespace terrazzo
