// The paper's Figure 9 as C. Misprints corrected here: `char argv[]`, and two unclosed braces.
#include <takt/process.h>

static long periods = 0;

// clang-format off
int main(int argc, char* argv[]){
initPeriodExe();
      (void)argc; (void)argv; //user program for initialize
  while(1){
      waitPeriod();
      ++periods; //user periodic body
  }
  return 0;
}
