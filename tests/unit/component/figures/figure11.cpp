// The paper's Figure 11 as C++. Misprints corrected here: `char argv[]`, `while(1){}`, and `retrun`.
#include <takt/process.h>

static int events = 0;

// clang-format off
int condition() {
  waitSporadic(); // wait for signal
  const int condition = ++events % 10 == 0; // check condition;
  if(condition)
       return TRUE; // condition is met.
  else
       return FALSE; //otherwise
}
int main(int argc, char* argv[]){
  initSporadicExe();
      (void)argc; (void)argv; //user program for initialize
  while(1){
      if (!condition()) // if not satisfied
         continue; // enter into wating state
      events = 0; //user sporadic body
  }
  return 0;
}
