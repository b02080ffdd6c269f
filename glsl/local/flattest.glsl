// The smallest number of kappa's code, which is a float's exponent and 11 bits: what is coded is kappa and this.
const float FLATTEST = 7.62939453125e-6;
