"""Problems with rows that hold exactly, beside CasADi with Ipopt."""
