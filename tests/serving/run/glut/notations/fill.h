void preenche();
